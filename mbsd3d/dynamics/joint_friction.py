"""Friction by reactions: loads w that follow from the multipliers, which follow from w, solved within one evaluation.

    M v_dot + J' lam = Q + E w,   lam = lam_0 + A w,   w_i = g_i(lam) = mu_i (|x_i| + |y_i| + ...),   x, y linear in lam

Of few frictions the columns A are solved for, and w by Newton's method; of many, w is a fixed point, found by
Anderson's method with a solution of the saddle point a pass. Where that does not contract by half a pass, by Newton's
method too. The gain is the spectral radius of D = dg/dw: from 1 on w does not exist, or is not the only one.
"""

import numpy as np

from ..compiler.decorators import allocating_kernel, inner_kernel, kernel
from ..compiler.late import late
from ..kernels.force_laws import apply_along_gradient
from ..kernels.vectors import add6, dot, put, put6, vec
from ..mechanism.forces.dry_friction import friction_coefficient, friction_size, length_of, pressing
from ..solver.saddle_point import SOLVED, solve_refined
from .applied_forces import right_sides

HOLDS_ITSELF = 2  # beside SOLVED and NOT_FINITE
NEWTON_FRICTIONS_MAX = 6  # [1] up to which columns cost no more than the passes of Anderson's method
NEWTON_STEPS_MAX = 50  # [steps] below a gain of 1 some ten are enough
NEWTON_LAST_STEP = 1e-8  # [1] relative step after which one more leaves rounding only, of complex parts too
PASSES_MAX = 40  # [passes] of Anderson's method
PASSES_KEPT = 4  # [passes] that Anderson's method combines
PASS_ROUNDING = 1e-13  # [1] relative change of w that ends the passes
CONTRACTION_MAX = 0.5  # [1] change by a pass over the change of w from which Newton's method takes over
GAIN_SQUARINGS = 10  # [1] of D for its spectral radius, which errs by the 1024th root of a condition
NEGLIGIBLE_SHARE = 1e-6  # [1] of the largest w: friction that need not settle by its own size
LOAD_MIN = 1e-300  # [N or N m] pressing load that counts as none


@inner_kernel
def friction_numbers(m, numbers):
    """Set the places of the forces whose laws read multipliers."""
    k = 0
    for i in range(m.force.shape[0]):
        if m.force[i].rows > 0:
            numbers[k] = i
            k += 1


@inner_kernel
def apply_friction(m, d, i, w):
    """Replace the friction of force i in Q by another size."""
    out = d.force[i]
    out.load = w - out.load
    apply_along_gradient(d, m.force[i].body, out)
    out.load, out.power = w, w * out.rate


@inner_kernel
def read_pressing(m, d, numbers, presses):
    """Set the pressing vectors (frictions, 2, 3) of the multipliers at hand."""
    for k in range(numbers.shape[0]):
        x, y = pressing(m, d, m.force[numbers[k]])
        put(presses[k, 0], x)
        put(presses[k, 1], y)


@inner_kernel
def unit_response(m, d, s, i):
    """Solve for what a unit of friction of force i changes of accelerations and multipliers."""
    for b in range(m.body.shape[0]):
        body = d.body[b]
        put6(body.top, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        put(body.turn, (0.0, 0.0, 0.0))
    for slot in range(2):
        b = m.force[i].body[slot]
        if b < m.body.shape[0]:
            gradient = d.force[i].gradient
            add6(d.body[b].top, vec(gradient[2 * slot]), vec(gradient[2 * slot + 1]))
    for k in range(m.row.shape[0]):
        d.row[k].bottom = 0.0
    return solve_refined(m, d, s)


@inner_kernel
def equations_of_friction(m, numbers, presses, columns, change, w, missed, D):
    """Set w - g(lam) and D = dg/dw at w, whose pressing vectors are presses + columns . change."""
    count = numbers.shape[0]
    for i in range(count):
        p = m.force[numbers[i]]
        x, y = vec(presses[i, 0]), vec(presses[i, 1])
        for j in range(count):
            c = change[j]
            u, v = columns[j, i, 0], columns[j, i, 1]
            x = (x[0] + c * u[0], x[1] + c * u[1], x[2] + c * u[2])
            y = (y[0] + c * v[0], y[1] + c * v[1], y[2] + c * v[2])
        missed[i] = w[i] - friction_size(m, p, x, y)
        mu, long_x, long_y = friction_coefficient(m, p), length_of(x), length_of(y)
        for j in range(count):
            D[i, j] = 0.0
            if long_x.real > LOAD_MIN:
                D[i, j] += mu * dot(x, vec(columns[j, i, 0])) / long_x
            if long_y.real > LOAD_MIN:
                D[i, j] += mu * dot(y, vec(columns[j, i, 1])) / long_y


@inner_kernel
def eliminate(D, x):
    """Solve x := (1 - D)^-1 x, with row exchanges; D is lost, and x is not finite where the matrix is singular."""
    n = x.shape[0]
    for i in range(n):
        for j in range(n):
            D[i, j] = (1.0 if i == j else 0.0) - D[i, j]
    for k in range(n):
        p = k
        for i in range(k + 1, n):
            if abs(D[i, k].real) > abs(D[p, k].real):
                p = i
        for j in range(n):
            D[k, j], D[p, j] = D[p, j], D[k, j]
        x[k], x[p] = x[p], x[k]
        for i in range(k + 1, n):
            f = D[i, k] / D[k, k]
            x[i] -= f * x[k]
            for j in range(k + 1, n):
                D[i, j] -= f * D[k, j]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            x[i] -= D[i, j] * x[j]
        x[i] /= D[i, i]


@inner_kernel
def feedback_bound(D, w):
    """Return a bound of the spectral radius of D: its largest row sum in units of w."""
    bound = 0.0
    for i in range(w.shape[0]):
        total = 0.0
        for j in range(w.shape[0]):
            total += abs(D[i, j].real) * w[j].real
        bound = max(bound, total / w[i].real if w[i].real > 0.0 else np.inf)
    return bound


@allocating_kernel
def spectral_radius(D):
    """Return the spectral radius of D by its powers."""
    B, logarithm, share = np.real(D).copy(), 0.0, 1.0
    for _ in range(GAIN_SQUARINGS):
        size = np.abs(B).max()
        if not size > 0.0:
            return 0.0
        logarithm += share * np.log(size)
        B = (B / size) @ (B / size)
        share *= 0.5
    size = np.abs(B).max()
    return np.exp(logarithm + share * np.log(size)) if size > 0.0 else 0.0


@inner_kernel
def set_columns(m, d, s, numbers, presses, columns):
    """Set the pressing vectors of the multipliers at hand, and those that a unit of each friction adds."""
    read_pressing(m, d, numbers, presses)
    for j in range(numbers.shape[0]):
        status = unit_response(m, d, s, numbers[j])
        if status != SOLVED:
            return status
        read_pressing(m, d, numbers, columns[j])
    return SOLVED


@inner_kernel
def settled(step, w):
    """Return whether a step of w is so small that one more leaves rounding only."""
    largest = 0.0
    for i in range(w.shape[0]):
        largest = max(largest, abs(w[i].real))
    for i in range(w.shape[0]):
        if not abs(step[i].real) <= NEWTON_LAST_STEP * (abs(w[i].real) + NEGLIGIBLE_SHARE * largest):
            return False
    return True


@allocating_kernel
def solve_by_columns(m, d, s, numbers):
    """Solve for w by Newton's method on the columns A, and for accelerations and multipliers with it.

    Steps that do not settle, and a gain from 1 on, mean that friction holds itself.
    """
    count, dtype = numbers.shape[0], d.row["lam"].dtype
    presses, columns = np.zeros((count, 2, 3), dtype), np.zeros((count, count, 2, 3), dtype)
    D = np.zeros((count, count), dtype)
    missed, w, change = np.zeros(count, dtype), np.zeros(count, dtype), np.zeros(count, dtype)
    for i in range(count):
        w[i] = d.force[numbers[i]].load
    status, last = set_columns(m, d, s, numbers, presses, columns), False
    if status != SOLVED:
        return status
    for _ in range(NEWTON_STEPS_MAX):
        equations_of_friction(m, numbers, presses, columns, change, w, missed, D)
        eliminate(D, missed)
        for i in range(count):
            w[i] -= missed[i]
            change[i] -= missed[i]
        if last:
            break
        last = settled(missed, w)
    if not last:
        return HOLDS_ITSELF
    equations_of_friction(m, numbers, presses, columns, change, w, missed, D)
    if not (feedback_bound(D, w) < 1.0 or spectral_radius(D) < 1.0):
        return HOLDS_ITSELF
    for i in range(count):
        apply_friction(m, d, numbers[i], w[i])
    right_sides(m, d)
    return solve_refined(m, d, s)


@allocating_kernel
def solve_by_passes(m, d, s, numbers):
    """Solve for w by Anderson's method, a solution of the saddle point a pass; by columns where that is slow."""
    count, dtype = numbers.shape[0], d.row["lam"].dtype
    presses, w, missed = np.zeros((count, 2, 3), dtype), np.zeros(count, dtype), np.zeros(count, dtype)
    w_before, missed_before = np.zeros(count, dtype), np.zeros(count, dtype)
    moves, turns = np.zeros((count, PASSES_KEPT), dtype), np.zeros((count, PASSES_KEPT), dtype)
    for i in range(count):
        w[i] = d.force[numbers[i]].load
    for k in range(PASSES_MAX):
        read_pressing(m, d, numbers, presses)
        for i in range(count):
            missed[i] = friction_size(m, m.force[numbers[i]], vec(presses[i, 0]), vec(presses[i, 1])) - w[i]
        size = np.abs(w).max()
        if np.abs(missed).max() <= PASS_ROUNDING * size:
            return SOLVED
        step = missed.copy()
        if k > 0:
            place, kept = (k - 1) % PASSES_KEPT, min(k, PASSES_KEPT)
            moves[:, place], turns[:, place] = w - w_before, missed - missed_before
            moved = np.abs(moves[:, place]).max()
            back = np.abs(moves[:, place] + turns[:, place]).max()
            if moved > NEWTON_LAST_STEP * size and not back <= CONTRACTION_MAX * moved:
                return solve_by_columns(m, d, s, numbers)
            shares = np.linalg.lstsq(turns[:, :kept].copy(), missed)[0]
            step -= (moves[:, :kept] + turns[:, :kept]) @ shares
        w_before[:], missed_before[:] = w, missed
        w += step
        for i in range(count):
            apply_friction(m, d, numbers[i], w[i])
        right_sides(m, d)
        status = solve_refined(m, d, s)
        if status != SOLVED:
            return status
    return solve_by_columns(m, d, s, numbers)


@late
@allocating_kernel
def settle_friction(m, d, s) -> int:
    """Solve for the friction that presses itself; the multipliers at hand belong to the loads in Q."""
    numbers = np.zeros(m.frictions, np.int64)
    friction_numbers(m, numbers)
    if np.iscomplexobj(d.z) or m.frictions <= NEWTON_FRICTIONS_MAX:
        return solve_by_columns(m, d, s, numbers)
    return solve_by_passes(m, d, s, numbers)


@late
@kernel
def pressing_loads(m, d, f, presses) -> None:
    """Set the pressing vectors (2, 3) of force f of the multipliers at hand."""
    x, y = pressing(m, d, m.force[f])
    put(presses[0], x)
    put(presses[1], y)


@kernel
def friction_feedback(m, d, s, numbers, presses, columns, none, missed, D):
    """Set D = dg/dw of the forces ``numbers``, with the rows, multipliers, loads and factor at hand.

    The other arrays are work space: presses (k, 2, 3), columns (k, k, 2, 3), none = 0 and missed (k,).
    """
    set_columns(m, d, s, numbers, presses, columns)
    equations_of_friction(m, numbers, presses, columns, none, none, missed, D)
