"""Loads of redundant joints by the stiffness of the joints, and how far tolerances of assembly move them.

Joints give way by ``delta_i = C_i lam_i`` along their rows, so little that the motion stays that of the rigid
mechanism. Of all multipliers with the same J'lam they carry those of the least energy ``lam'C lam / 2``. Rows that
are d apart as they are assembled (0 = they fit) add to these; with S the scales of rows and N the null space of
(S J)' they are

    lam = lam_el + G d,   lam_el = lam - G C lam,   G = S N (N'S C S N)^-1 N'S.

A wrench T lam with ``|d_i| <= tolerance_i`` is therefore ``T lam_el`` plus or minus ``|T G| tolerance``. C is in metres
per newton or radians per newton metre, so nothing depends on the unit of length.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg

from ..base.checks import as_tuple, check_choice, number, short_repr
from ..base.errors import InputError
from ..equations.compiled import Compiled
from ..mechanism.joints import Joint
from .reactions import Group, Open, RunRows, tolerance_of

SHARES = ("least norm", "elastic", "range")
PAIRS = {  # what is given of a joint: units, remedy
    "stiffness": ("a translational [N/m] and a rotational stiffness [N m/rad], both > 0", "(1e8, 1e5)"),
    "tolerances": ("a tolerance in position [m] and one in direction [rad], both >= 0", "(1e-5, 1e-4)"),
}

PairsOfJoints = tuple[float, float] | Mapping[Any, tuple[float, float]]


class Elasticity(NamedTuple):
    """What joints give way by, row by row; NaN for joints of which nothing was given."""

    stiffness: np.ndarray  # (rows,) N/m or N m/rad
    tolerance: np.ndarray | None  # (rows,) m or rad; None = not asked for

    @classmethod
    def of(
        cls, compiled: Compiled, shares: str, stiffness: PairsOfJoints | None, tolerances: PairsOfJoints | None
    ) -> "Elasticity | None":
        """Return the given values, None for shares of least norm; InputError for values missing or unused."""
        if isinstance(shares, str) and shares == "least norm" and stiffness is None and tolerances is None:
            return None
        check_choice(shares, SHARES, "solution.reaction: shares")
        needed = {"stiffness": shares != "least norm", "tolerances": shares == "range"}
        for name, given in (("stiffness", stiffness), ("tolerances", tolerances)):
            what, example = PAIRS[name]
            if needed[name] and given is None:
                raise InputError(f'solution.reaction: shares="{shares}" needs {name}: {what}; give {name}={example}')
            if given is not None and not needed[name]:
                raise InputError(f'solution.reaction: shares="{shares}" uses no {name}; leave {name}= out')
        if stiffness is None:
            return None
        tolerance = None if tolerances is None else by_row(compiled, tolerances, "tolerances")
        return cls(by_row(compiled, stiffness, "stiffness"), tolerance)


def by_row(compiled: Compiled, given: PairsOfJoints, name: str) -> np.ndarray:
    """Return for every row the number of its joint that has its unit; NaN where a joint is not given."""
    system, metres = compiled.system, compiled.model.row["metres"] == 1
    pairs = given if isinstance(given, Mapping) else {None: given}
    found, seen = np.full(metres.size, np.nan), set[str]()
    if None in pairs:
        found[:] = np.where(metres, *pair_of(pairs[None], name, "every joint"))
    for key in (key for key in pairs if key is not None):
        joint: Joint = system.part(key, "joints")
        joint_name, rows = system.name(joint), compiled.rows[id(joint)]
        if joint_name in seen:
            raise InputError(f"solution.reaction: {name}: '{joint_name}' is given twice; give each joint once")
        seen.add(joint_name)
        found[rows] = np.where(metres[rows], *pair_of(pairs[key], name, f"'{joint_name}'"))
    return found


def pair_of(pair: Any, name: str, joint: str) -> tuple[float, float]:
    """Return two numbers of a joint, checked."""
    (meaning, example), what = PAIRS[name], f"solution.reaction: {name} of {joint}"
    two = as_tuple(pair, what, meaning) if not isinstance(pair, str) else ()
    if len(two) != 2:
        raise InputError(f"{what}: {short_repr(pair)} is not {meaning}; give e.g. {example}")
    if name == "stiffness":
        return number(two[0], what, positive=True), number(two[1], what, positive=True)
    return number(two[0], what, minimum=0.0), number(two[1], what, minimum=0.0)


def elastic_shares(
    run: RunRows, lam: np.ndarray, group: Group, given: Elasticity, arms: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return multipliers (samples, rows) of least elastic energy, and what tolerances do to the wrench of a group.

    ``lam``: of the run; ``arms`` (samples, 3): from O of body b to the joint's point, world [m]. The second one is
    (samples, 6, rows): force [N] and moment [N m] about that point by each row that is as far off as it may be.
    Only rows that share loads with the group are considered.
    """
    compiled = run.compiled
    shared, apart = lam.copy(), np.zeros((run.t.size, 6, lam.shape[1]))
    data, scale = compiled.data(), compiled.model.row["scale"]
    for k in range(run.t.size):
        found, J = run.probe(k, data)
        for island in (island for island in found if np.isin(group.rows, island.rows).any()):
            own = island.rows[np.abs(island.N).max(axis=1) > tolerance_of([island])]
            check_given(compiled, own, given)
            unit = gradients(compiled, J, own)
            G = stiff_combinations(island, own, scale, unit, given)
            shared[k, own] -= G @ (unit**2 / given.stiffness[own] * lam[k, own])
            if given.tolerance is not None:
                apart[k][:, own] = group.wrench(J, own, arms[k]) @ G * (unit * given.tolerance[own])
    return shared, apart


def check_given(compiled: Compiled, rows: np.ndarray, given: Elasticity) -> None:
    """Raise an error for a joint that shares loads and for which nothing was given."""
    for name, values in (("stiffness", given.stiffness), ("tolerances", given.tolerance)):
        if values is not None and np.isnan(values[rows]).any():
            joint = compiled.system.joints[compiled.row_joint[rows[np.isnan(values[rows])][0]]]
            raise InputError(
                f"solution.reaction: {name}: '{compiled.system.name(joint)}' shares the load, and nothing is given of "
                f"it; give {PAIRS[name][0]}, or with the key None those of all other joints"
            )


def gradients(compiled: Compiled, J: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return the growth of rows (m,) if b moves by a metre or a radian along them.

    It is 1 but for joints as `ConstantVelocity`; rows of couplings over several hinges count in their own unit.
    """
    row = compiled.model.row
    part = np.where((row["metres"][rows] == 1)[:, None], J[rows, 1, :3], J[rows, 1, 3:])
    size = np.linalg.norm(part, axis=1)
    of_two = (row["body"][rows, 2:] < 0).all(axis=1) & (size > 0.0)
    return np.where(of_two, size, 1.0)


def stiff_combinations(
    island: Open, own: np.ndarray, scale: np.ndarray, unit: np.ndarray, given: Elasticity
) -> np.ndarray:
    """Return G (m, m) of rows that share loads: multipliers that belong to rows that are one unit apart."""
    SN = scale[own, None] * island.N[np.searchsorted(island.rows, own)]
    flexible = unit / np.sqrt(given.stiffness[own])
    R = scipy.linalg.qr(flexible[:, None] * SN, mode="r")[0][: SN.shape[1]]
    half = scipy.linalg.solve_triangular(R, SN.T, trans="T")
    return half.T @ half
