"""Stretches, slips and tensions of the sections of ropes: see `mechanism.forces.rope` for the geometry."""

import numpy as np

from ..compiler.decorators import inner_kernel, merged_kernel
from .coordinates import arctan2, value_and_rate
from .force_laws import series, stop_load
from .kinds import SLIDE
from .vectors import add, arm, cross, dot, point, point_velocity, scale, sub, vec

# Arrays of the law in Model.number, one number a node each; those of spans and sections have one to spare.
ARMS, GRIPS, OFFSETS, RESTS, STIFFNESSES, DAMPINGS, TURNS = range(7)
# Arrays of what it finds, in Data.scratch.
STRETCHES, RATES, TENSIONS, WRAPS, SLIPS = range(5)
SLIP_SWEEPS_MAX = 2000  # [1] over the pulleys of a rope until their slips fit each other; some tens of four pulleys
SLIP_ROUNDING = 1e-15  # [1] of the slips: change in a sweep that counts as none


@merged_kernel
def found(d, p, which):
    """Return an array of what the law of a rope finds, one number a node."""
    count = p.option + 1
    return d.scratch[which * count : (which + 1) * count]


@merged_kernel
def given(m, p, which):
    """Return an array of what the law of a rope reads, one number a node."""
    return series(m, p, which, p.option + 1)


@inner_kernel
def span(m, d, p, k, t):
    """Return (M without turn, its rate, its gradient by the gap from a to b, direction [rad]) of span k."""
    i = m.measure[p.measure + k].coordinate
    x = m.coordinate[i]
    a, b = d.body[x.body[0]], d.body[x.body[1]]
    sa, sb = arm(a, x.point[0]), arm(b, x.point[1])
    gap = sub(point(b, sb), point(a, sa))
    moving = sub(sub(point_velocity(b, sb), point_velocity(a, sa)), cross(vec(a.w), gap))  # seen from a
    if x.kind == SLIDE:
        length = np.sqrt(dot(gap, gap))
        g = scale(1.0 / length, gap)
        return length, dot(g, moving), g, 0.0 * length
    arms = given(m, p, ARMS)
    rho = arms[k] - arms[k + 1]
    xa, ya = arm(a, x.axis[0]), arm(a, x.axis[1])
    n = cross(xa, ya)
    off = dot(gap, n)
    flat = sub(gap, scale(off, n))
    square = dot(flat, flat)
    tangent = square - rho * rho
    if tangent.real <= 0.0:
        tangent = np.nan * tangent  # one circle inside the other: the run names the rope
    level = np.sqrt(tangent)
    length = np.sqrt(tangent + off * off)
    g = add(scale(1.0 / length - rho * rho / (square * level), flat), scale(rho / square, cross(n, flat)))
    g = add(g, scale(off / length, n))
    direction = value_and_rate(m, d, i, t)[0] + arctan2(rho + 0.0 * level, level)
    return length + rho * direction, dot(g, moving), g, direction


@inner_kernel
def turned(m, d, p, k, t):
    """Return turn and rate of the second circle of span k by its first; 0 where there are not two."""
    place = int(given(m, p, TURNS)[k].real)
    if place < 0:
        zero = 0.0 * d.scratch[0]
        return zero, zero
    return value_and_rate(m, d, m.measure[p.measure + place].coordinate, t)


@inner_kernel
def find_stretches(m, d, p, t):
    """Find stretch and rate of all sections, without the rates of slips, and all wraps; return the least wrap."""
    arms, grips, offsets, rests = given(m, p, ARMS), given(m, p, GRIPS), given(m, p, OFFSETS), given(m, p, RESTS)
    stretch, rate, wraps = found(d, p, STRETCHES), found(d, p, RATES), found(d, p, WRAPS)
    stretch[:] = 0.0
    rate[:] = 0.0
    wraps[:] = 0.0
    section, state, least, before = 0, p.state, np.inf, 0.0 * stretch[0]
    for k in range(p.option):
        length, speed, _, direction = span(m, d, p, k, t)
        turn, turn_rate = turned(m, d, p, k, t)
        if k > 0:
            way = np.sign(arms[k].real)
            wraps[k] = offsets[k] + way * (direction - before)
            if way != 0.0:
                least = min(least, wraps[k].real)
            if grips[k].real != 0.0:
                section += 1
                if grips[k].real < np.inf:
                    stretch[section - 1] += d.z[state]
                    stretch[section] -= d.z[state]
                    state += 1
        stretch[section] += length + arms[k + 1] * turn - rests[k]
        rate[section] += speed + arms[k + 1] * turn_rate
        before = direction - turn  # in the axes of the next pulley
    return least


@inner_kernel
def slip_of(x, a, k, c, i, hold):
    """Return the rate at which a rope slips from section i to the next, if the tensions differ by more than 1 / hold.

    Rates ``a`` of stretch are those without this slip. It slips as fast as leaves the limit T_high hold = T_low.
    """
    j = i + 1
    own, next_ = k[i] * x[i] + c[i] * a[i], k[j] * x[j] + c[j] * a[j]
    taut, next_taut = x[i].real > 0.0, x[j].real > 0.0
    low = max(own.real, 0.0) if taut else 0.0
    high = max(next_.real, 0.0) if next_taut else 0.0
    y, both = 0.0 * own, (own * c[j] + next_ * c[i]).real > 0.0
    if high * hold.real > low:
        y = (hold * next_ - own) / (c[i] + hold * c[j]) if taut and both else next_ / c[j]
    elif low * hold.real > high:
        y = (next_ - hold * own) / (c[j] + hold * c[i]) if next_taut and both else -own / c[i]
    return y


@inner_kernel
def find_slips(m, d, p):
    """Find the slips of all rough pulleys, each with those of its neighbours until all fit, and their rates."""
    n, grips, k, c = p.option, given(m, p, GRIPS), given(m, p, STIFFNESSES), given(m, p, DAMPINGS)
    x, rate, wraps, slips = found(d, p, STRETCHES), found(d, p, RATES), found(d, p, WRAPS), found(d, p, SLIPS)
    slips[:] = 0.0
    for _ in range(SLIP_SWEEPS_MAX):
        section, change, most = 0, 0.0, 0.0
        for node in range(1, n):
            if grips[node].real == 0.0:
                continue
            if grips[node].real < np.inf:
                last = slips[node]
                rate[section] -= last
                rate[section + 1] += last
                slips[node] = slip_of(x, rate, k, c, section, np.exp(-grips[node] * wraps[node]))
                rate[section] += slips[node]
                rate[section + 1] -= slips[node]
                change, most = max(change, abs(slips[node] - last)), max(most, abs(slips[node]))
            section += 1
        if change <= SLIP_ROUNDING * most or p.states <= 1:
            break
    state = p.state
    for node in range(1, n):
        if 0.0 < grips[node].real < np.inf:
            d.state_rate[state] = slips[node]
            state += 1


@inner_kernel
def tension_of_section(m, d, p, i, t):
    """Return the tension of section i, from 0."""
    find_stretches(m, d, p, t)
    find_slips(m, d, p)
    k, c = given(m, p, STIFFNESSES)[i], given(m, p, DAMPINGS)[i]
    return stop_load(k, c, found(d, p, STRETCHES)[i], found(d, p, RATES)[i])[0]
