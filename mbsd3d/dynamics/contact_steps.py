"""Contacts and stops that a step could miss: bodies are separated at both of its ends and in contact in between.

The stages of a step see none of it if they lie before and after. So a step between two moments in the air may not turn
a surface by more than a radian, unless it looks the same all the time, nor move a sphere farther than the sphere or
capsule that it may pass is away; and where the clearance falls and rises again so that it may vanish, the step is tried
anew up to where it is least.

The load of a contact jumps or kinks where bodies touch and lift off, and where damping ends it before that. Adaptive
steps find that by their error. Fixed steps would lose their order there: explicit ones are split at that time; implicit
ones, which have no solution with an end at a jump, are not, and the certificate judges by how much the load changed.
"""

from collections.abc import Sequence

import numpy as np

from ..compiler.decorators import inner_kernel, late_kernel
from ..compiler.late import late_choice
from ..kernels.surfaces import contact_parameters, meeting, pressure, shortest_line
from ..kernels.vectors import arm, columns, cross, dot, point_velocity, sub, vec
from ..mechanism.force_element import ForceElement
from ..mechanism.forces.contact import Contact
from ..mechanism.forces.end_stop import Stop
from ..mechanism.switching import is_switching
from .applied_forces import kernels_of_all_forces

TURN_PER_STEP_MAX = 1.0  # [rad] of a surface in a step between two moments without contact
TURN_ROUNDING = 1e-6  # [1] of the turn: rounding of it, which changes no clearance
CLEARANCE_DIP_SHARE = 0.25  # [1] of the depth of a dip: a cubic errs by a twelfth of it if a surface turns by a radian
LANDING_SHARE_MIN = 1e-6  # [1] of a fixed step: it is split no nearer to its start
LANDING_MISS_SHARE = 1e-4  # [1] of a step: it ends that far behind the end of a load, whose kink then counts its square
LANDING_TRIES_MAX = 10  # [1] for the place where a fixed step is split; each errs by the fourth power of the one before
OF_CONTACT = -1  # in place of the number of a gap
GAPS = kernels_of_all_forces("gap")


def watched_gaps(forces: Sequence[ForceElement]) -> np.ndarray:
    """Return (k, 3): numbers of a force that touches and lifts off, of its kernel of a gap, and of the limit."""
    found = [(i, OF_CONTACT, 0) for i, force in enumerate(forces) if isinstance(force, Contact)]
    for i, force in enumerate(forces):
        if isinstance(force, Stop) and not is_switching(force):
            found += [(i, GAPS.index(type(force).gap), limit) for limit in range(force.gaps)]
    return np.array(found, int).reshape(-1, 3)


store_gap = late_choice(__name__, "store_gap", GAPS)


@inner_kernel
def largest(a):
    """Return the largest component of a vector by size."""
    return max(abs(a[0]), abs(a[1]), abs(a[2]))


@inner_kernel
def changing_turn(m, d, p, normal):
    """Return the angular velocity [rad/s] by which a contact sees its surfaces turn; 0 where they look the same."""
    a, b = d.body[p.body[0]], d.body[p.body[1]]
    w_a, w_b = vec(a.w), vec(b.w)
    rate_a, rate_b = np.sqrt(dot(w_a, w_a)), np.sqrt(dot(w_b, w_b))
    own = contact_parameters(m.number, p.number)
    u, r, size = columns(b, p.frame[1]), vec(own.radii), own.size
    w = (dot(u[0], w_b), dot(u[1], w_b), dot(u[2], w_b))
    squares = (r[0] * r[0], r[1] * r[1], r[2] * r[2])
    shape = (w[0] * (squares[1] - squares[2]), w[1] * (squares[2] - squares[0]), w[2] * (squares[0] - squares[1]))
    centre = sub(arm(b, p.point[1]), vec(b.s))
    round_ = largest(shape) <= TURN_ROUNDING * rate_b * size * size
    centred = largest(cross(w_b, centre)) <= TURN_ROUNDING * rate_b * size
    if own.other > 0.0:
        return max(0.0 if centred else rate_b, passing_rate(own, p, a, b))
    level = largest(cross(w_a, normal)) <= TURN_ROUNDING * rate_a
    return max(0.0 if round_ and centred else rate_b, 0.0 if level else rate_a)


@inner_kernel
def passing_rate(own, p, a, b):
    """Return the speed of a sphere past another surface over the distance of their centres [1/s].

    A step h with h r <= 1 for the rate r at its start and h r <= 2 at its end cannot begin before the other body and
    end behind it, at constant acceleration. Where a turns and the nearest point of its axis is not its centre of mass,
    its angular velocity counts as well.
    """
    line, centre = shortest_line(own, p, a, b)
    on_b = sub(centre, vec(b.r))
    on_a = sub(sub(centre, line), vec(a.r))
    v, w, aside = sub(point_velocity(b, on_b), point_velocity(a, on_a)), vec(a.w), sub(on_a, vec(a.s))
    off = cross(w, aside)
    rate_a = np.sqrt(dot(w, w)) if dot(off, off) > (TURN_ROUNDING * own.other) ** 2 * dot(w, w) else 0.0
    return max(rate_a, np.sqrt(dot(v, v) / dot(line, line)))


@inner_kernel
def watch_contacts(m, d, run, end, t):
    """Store clearance, its rate, `changing_turn`, load and overlap of contacts and stops at the state in d: an end of
    a step."""
    for k in range(run.contacts.shape[0]):
        p, gap_of, seen = m.force[run.contacts[k, 0]], run.contacts[k, 1], run.gaps[k, end]
        if gap_of != OF_CONTACT:
            store_gap(gap_of, m, d, p, run.contacts[k, 2], t, seen)
            continue
        own = contact_parameters(m.number, p.number)
        plane, _, _, gap, velocity = meeting(own, p, d.body[p.body[0]], d.body[p.body[1]])
        rate = dot(plane[2], velocity)
        seen[0], seen[1], seen[2], seen[3] = gap, rate, changing_turn(m, d, p, plane[2]), pulling(own, gap, -rate)
        seen[4] = -gap / (own.radii[0] + own.other) if own.other > 0.0 else 0.0


@inner_kernel
def pulling(own, gap, speed):
    """Return the normal force [N] of a contact as it would be if it could pull."""
    _, elastic, _ = pressure(own, gap, speed)
    return elastic * (1.0 + own.loss * speed) + own.damping * speed


@inner_kernel
def begin_step(run):
    """Note the overlap at the start of a step, and set its greatest length from what may turn before it is touched.

    Fixed steps have none.
    """
    for k in range(run.contacts.shape[0]):
        if run.gaps[k, 0, 4] > run.now.overlap:
            run.now.overlap, run.now.overlap_by = run.gaps[k, 0, 4], run.contacts[k, 0]
    run.now.longest = np.inf
    if run.task.steps > 0:
        run.now.retried = 0
        return
    for k in range(run.contacts.shape[0]):
        seen = run.gaps[k, 0]
        if seen[0] > 0.0 and seen[2] > 0.0:
            run.now.longest = min(run.now.longest, TURN_PER_STEP_MAX / seen[2])


@inner_kernel
def start_watching(m, d, run):
    """Start the watch at a state, which is in d."""
    watch_contacts(m, d, run, 0, run.now.t)
    begin_step(run)


@inner_kernel
def advance_contact_watch(run):
    """Make the end of a step the start of the next one."""
    for k in range(run.contacts.shape[0]):
        for j in range(5):
            run.gaps[k, 0, j] = run.gaps[k, 1, j]
    begin_step(run)


@inner_kernel
def least_of_cubic(start, end, h):
    """Return (fraction of a step, value) where a cubic that falls at its start and rises at its end is least."""
    a, rise = start[1] * h, end[0] - start[0]
    b = 3.0 * rise - h * (2.0 * start[1] + end[1])
    c = h * (start[1] + end[1]) - 2.0 * rise
    x = -a / (b + np.sqrt(b * b - 3.0 * a * c))
    return x, start[0] + x * (a + x * (b + x * c))


@late_kernel
def step_fraction_to_retry(m, d, run, h) -> float:
    """Return the fraction of the step h, whose end is in d, to retry; 1 if the step hides no contact."""
    watch_contacts(m, d, run, 1, run.now.t + h)
    part, shallow = 1.0, run.task.rtol * m.length
    for k in range(run.contacts.shape[0]):
        start, end = run.gaps[k, 0], run.gaps[k, 1]
        if start[0] > 0.0 and end[0] > 0.0:
            turn = h * end[2]
            if turn > 2.0 * TURN_PER_STEP_MAX:
                part = min(part, TURN_PER_STEP_MAX / turn)
            if start[1] < 0.0 and end[1] > 0.0:
                x, least = least_of_cubic(start, end, h)
                if least < CLEARANCE_DIP_SHARE * (min(start[0], end[0]) - least) - shallow:
                    part = min(part, x)
    return part


@inner_kernel
def fraction_to_level(start, end, h, level):
    """Return the fraction of a step where the cubic of a clearance passes a level that lies between both ends."""
    a, rise = start[1] * h, end[0] - start[0]
    b = 3.0 * rise - h * (2.0 * start[1] + end[1])
    c = h * (start[1] + end[1]) - 2.0 * rise
    low, high = 0.0, 1.0
    for _ in range(52):  # bits of a double
        x = 0.5 * (low + high)
        if (start[0] + x * (a + x * (b + x * c)) > level) == (start[0] > level):
            low = x
        else:
            high = x
    return high


@inner_kernel
def fraction_of_load(start, end):
    """Return the fraction of a step that ends in touch, up to behind where the load begins or ends; 1 if it does not.

    It is found as if the load changed evenly, so that a few tries come to it.
    """
    before, after = start[3], end[3]
    if before * after >= 0.0:
        return 1.0
    return min(1.0, before / (before - after) + LANDING_MISS_SHARE)


@late_kernel
def landing_fraction(m, d, run, h) -> float:
    """Return the fraction of the fixed step h, whose end is in d, up to where a load begins or ends; 1 if none does.

    The load jumps as bodies touch. So that no stage lies on the wrong side, one step ends less than rtol lengths before
    that, and the next one, which is short, as close behind it.
    """
    part, slack = 1.0, run.task.rtol * m.length
    for k in range(run.contacts.shape[0]):
        start, end = run.gaps[k, 0], run.gaps[k, 1]
        if start[0] > slack and end[0] < 0.0:
            part = min(part, fraction_to_level(start, end, h, 0.5 * slack))
        elif start[0] > 0.0 and end[0] < -slack:
            part = min(part, fraction_to_level(start, end, h, -0.5 * slack))
        elif start[0] <= 0.0 and end[0] > slack:
            part = min(part, fraction_to_level(start, end, h, 0.5 * slack))
        elif start[0] <= 0.0:
            part = min(part, fraction_of_load(start, end))
        elif end[0] > 0.0 and start[1] < 0.0 and end[1] > 0.0:
            x, least = least_of_cubic(start, end, h)
            if least < CLEARANCE_DIP_SHARE * (min(start[0], end[0]) - least) - slack:
                part = min(part, x)
    apart = (run.task.t_end - run.task.t_start) / run.task.steps
    return max(part, LANDING_SHARE_MIN * apart / h)


@inner_kernel
def note_jump(m, run, h):
    """Add up the changes of acceleration times h, per greatest velocity, of all steps in which bodies touch."""
    touching = -1
    for k in range(run.contacts.shape[0]):
        if run.gaps[k, 0, 0] > 0.0 and run.gaps[k, 1, 0] < -run.task.rtol * m.length:
            touching = run.contacts[k, 0]
    if touching < 0:
        return
    n, most = m.body.shape[0], 0.0
    for i in range(n):
        u = 7 * n + 6 * i
        for j in range(3):
            linear, angular = run.trial_rate[u + j] - run.dy[u + j], run.trial_rate[u + 3 + j] - run.dy[u + 3 + j]
            most = max(most, abs(linear) / run.now.speed, abs(angular) / run.now.turn)
    run.now.jump += h * most
    if h * most > run.now.jump_most:
        run.now.jump_most, run.now.jump_by = h * most, touching


@inner_kernel
def may_hide_contact(m, d, run, h, implicit):
    """Return True for a step h, whose end is in d, that is rejected for a contact.

    An adaptive one could hide it; in a fixed one, which is split, it begins or ends.
    """
    if run.contacts.shape[0] == 0:
        return False
    fixed = run.task.steps > 0
    if not fixed:
        part = step_fraction_to_retry(m, d, run, h)
        run.now.step = part * h if part < 1.0 else run.now.step
    else:
        watch_contacts(m, d, run, 1, run.now.t + h)
        part = landing_fraction(m, d, run, h) if not implicit and run.now.retried < LANDING_TRIES_MAX else 1.0
        if part < 1.0:
            run.now.longest = part * h
        else:
            note_jump(m, run, h)
    if part < 1.0:
        run.now.rejected += 1
        run.now.retried += 1
    return part < 1.0
