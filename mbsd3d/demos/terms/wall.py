"""Errors of omitted terms: what is lost with each term that one may forget, in numbers."""

from typing import Any

import numpy as np

from mbsd3d import GROUND, Body, Revolute, Spherical, State, System, shapes, simulate

from ...api.viewable import AnimateOptions
from ...base.rotations import H
from ..base import Show
from ..figure import Line, Table
from ..form import Ablation, Beat, Builder, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share
from ..shafts import crank

INITIAL_GAP, DECAY_RATE, STEP_COUNT = (
    1e-3,
    10.0,
    200,
)  # m, opened on purpose; 1/s, both roots of Baumgarte; of the quaternion's RK4
BAUMGARTE: dict[str, Any] = {"stabilisation": "baumgarte", "baumgarte": (2 * DECAY_RATE, DECAY_RATE**2)}
TERMS = {"gyroscopic": "no w x I w", "centripetal": "no m w x (w x s)", "gamma": "no -J_dot v"}
RUNS: dict[str, dict[str, Any]] = {"all terms": {}, **{text: {term: False} for term, text in TERMS.items()},
        "no stabilisation": {"stabilisation": "none"}, "Baumgarte": BAUMGARTE}  # fmt: skip


def mechanism(*, arm=0.5, turn=2 * np.pi) -> System:
    """Build a flywheel on a hinge, its centre of mass an arm [m] off the axis, turning [rad/s]; no gravity."""
    shape = (
        shapes.Disc(0.5 * arm, 0.12 * arm),
        shapes.Cylinder(0.06 * arm, arm, "x", at=(-0.5 * arm, 0, 0)),
        shapes.Torus(0.14 * arm, 0.04 * arm, at=(-arm, 0, 0)),
    )
    wheel = Body("wheel", 1.0, (0.1, 0.1, 0.1), position=(arm, 0, 0), omega=(0, 0, turn), shape=shape)
    return System([wheel], [Revolute(GROUND, wheel, at=(0, 0, 0), axis=(0, 0, 1), name="hinge")], gravity=(0, 0, 0))


def free_body(I, spin) -> System:
    """Build a body without forces, turning about an axis that is not principal."""
    return System([Body("body", 1.0, I, omega=spin, shape="box")], gravity=(0, 0, 0))


def top() -> System:
    """Build a fast top, its reference point between pivot and centre of mass, so that every term of the equations
    matters.
    """
    moments = (0.234375, 0.46875, 0.234375)
    body = Body("top", 15.0, moments, position=(0, 0.5, 0), com=(0, 0.5, 0), omega=(0, 150, -4.61538))
    return System([body], [Spherical(GROUND, body, at=(0, 0, 0), name="pivot")])


def drifted(angle, arm):
    """Return the gap of the hinge without -J_dot v [m]: the centre of mass flies straight on while the wheel turns."""
    return arm * np.hypot(1 - np.cos(angle), angle - np.sin(angle))


def closing(t):
    """Return the gap [m] under Baumgarte's c_ddot + 2 (10/s) c_dot + (10/s)^2 c = 0, opened by `INITIAL_GAP` at
    rest."""
    return INITIAL_GAP * (1 + DECAY_RATE * t) * np.exp(-DECAY_RATE * t)


def ghost(turns):
    """Return the angle of e = (1, w t / 2), the result of a constant e_dot [deg]: 2 atan(pi turns)."""
    return np.degrees(2 * np.arctan(np.pi * np.asarray(turns)))


def theory(*, arm, turn, I, spin, terms):
    """Return the error of each omission: closed forms for a constant w; without w x I w L turns with the body about
    w."""
    require(terms in ("forgotten", "kept"), f"demo 'wall': terms = {terms!r}; give 'forgotten' or 'kept'")
    lost, w, L = terms == "forgotten", np.array(spin), np.multiply(I, spin)
    shaken = own_crank().theory
    return {
        "energy_change_J": 0.0,
        "momentum_change_Nms": float(lost * 2 * np.linalg.norm(L - (L @ w) / (w @ w) * w)),
        "crank_1x_N": shaken["along_1x_without_centripetal_N" if lost else "along_1x_N"],
        "hinge_gap_m": lost * drifted(2 * np.pi, arm),
        "gap_none_m": INITIAL_GAP, "gap_baumgarte_m": closing(2 * np.pi / abs(turn)), "gap_projection_m": 0.0,
        "quaternion_deg": float(ghost(1.0)) if lost else 360.0,
        "quaternion_length": np.hypot(1, np.pi) if lost else 1.0,
    }  # fmt: skip


def own_crank() -> Builder:
    """Return the engine of the demo ``crank``."""
    return Builder(crank.demo, crank.demo.parameters)


def opened(system, t, stabilisation):
    """Simulate the flywheel with its hinge a millimetre apart, at rest, at the start."""
    start = system.state()
    apart = State(start.t, start.q + INITIAL_GAP * np.eye(7)[0], start.v)
    held = BAUMGARTE if stabilisation == "baumgarte" else {"stabilisation": stabilisation}
    return simulate(system, t, state=apart, rtol=1e-12, output=51, as_built=2 * INITIAL_GAP, **held)


def quaternions(h_dot):
    """Integrate e_ddot = (H w_dot + H_dot w) / 2 by RK4, one turn about z in 1 s, or without H_dot, shape (STEP_COUNT +
    1, 4).
    """
    w, e = np.array([0.0, 0.0, 2 * np.pi]), np.array([1.0, 0.0, 0.0, 0.0])

    def rate(y):
        return np.concatenate([y[4:], 0.5 * H(y[4:]) @ w if h_dot else np.zeros(4)])

    path, dt = [np.concatenate([e, 0.5 * H(e) @ w])], 1.0 / STEP_COUNT
    for _ in range(STEP_COUNT):
        y = path[-1]
        k1 = rate(y)
        k2 = rate(y + 0.5 * dt * k1)
        k3 = rate(y + 0.5 * dt * k2)
        path.append(y + dt / 6 * (k1 + 2 * k2 + 2 * k3 + rate(y + dt * k3)))
    return np.array(path)[:, :4]


def measure(build, terms_off, *, arm, turn, I=(1.0, 2.0, 3.0), spin=(1.0, 2.0, 2.0), terms="forgotten") -> Measured:
    """Measure half a turn of the free body, a turn of crank, flywheel and quaternion, each without its term (or with
    it).
    """
    kept, t, half_turn = terms == "kept", 2 * np.pi / abs(turn), np.pi / float(np.linalg.norm(spin))
    free = simulate(free_body(I, spin), half_turn, gyroscopic=kept, rtol=1e-12, output=51)
    engine = crank.one_turn(own_crank()(), crank.demo.parameters["rpm"], centripetal=kept)
    flying = simulate(build(), t, gamma=kept, stabilisation="none", rtol=1e-12, output=51)
    apart = {name: opened(build(), t, name) for name in ("none", "baumgarte", "projection")}
    gaps = {name: np.linalg.norm(run.point("wheel", (-arm, 0, 0)), axis=1) for name, run in apart.items()}
    gap, L, energy = np.linalg.norm(flying.point("wheel", (-arm, 0, 0)), axis=1), free.momentum().angular, free.energy()
    e, time = quaternions(kept), np.linspace(0, 1, STEP_COUNT + 1)
    angle = np.degrees(2 * np.arctan2(e[:, 3], e[:, 0]))
    values = {
        "energy_change_J": energy.total[-1] - energy.total[0], "momentum_change_Nms": np.linalg.norm(L[-1] - L[0]),
        "crank_1x_N": crank.amplitudes(crank.block_load(engine)[0][:, 2])[0], "hinge_gap_m": gap[-1],
        **{f"gap_{name}_m": found[-1] for name, found in gaps.items()},
        "quaternion_deg": angle[-1], "quaternion_length": np.linalg.norm(e[-1]),
    }  # fmt: skip
    tops = {name: simulate(top(), 2.0, output=201, **changes) for name, changes in RUNS.items()}
    checks = [run.certificate.checks for run in tops.values()]
    apart_of = {"none": "no stabilisation", "baumgarte": "Baumgarte", "projection": "projection"}
    dots = {"none": INITIAL_GAP + 0 * flying.t, "baumgarte": closing(flying.t)}
    lines = [Line(f"1 mm apart, {text}", np.maximum(gaps[name], 1e-18), apart[name].t,
                  (flying.t, dots[name]) if name in dots else None) for name, text in apart_of.items()]  # fmt: skip
    curves = [
        Table("error of the check, bold: too large [-]", list(tops), [check.name for check in checks[0]],
              [[check.error for check in row] for row in checks], [[check.passed for check in row] for row in checks],
              "which check of the certificate sees it"),
        Curve("gap [m]", flying.t[1:], np.maximum(gap[1:], 1e-18), (flying.t[1:], drifted(turn * flying.t[1:], arm)),
              title="gap of a hinge during one turn", name="no -J_dot v", more=lines, logarithmic=True),
        Curve("rotation angle [deg]", time, angle, (time, ghost(time)), title="one turn of a quaternion",
              name="without H_dot", more=[Line("100 |e|, 100 for a rotation", 100 * np.linalg.norm(e, axis=1),
                                              theory=(time, 100 * np.hypot(1, np.pi * time))),
                                         Line("true angle", 360 * time)]),
    ]  # fmt: skip
    astray = AnimateOptions(
        title="without w x I w: the angular momentum of a free body turns with it", curves=["momentum", "energy"],
        shown=["angular momentum", "angular velocity"],
    )  # fmt: skip
    return Measured(values, [flying, free, engine, *apart.values()], curves, {"free_body": Show(free, astray)})


demo = Demo(
    __name__,
    title="The wall: what each forgotten term breaks",
    question="Which terms do models of machines in space forget, and who would notice?",
    beats=(
        Beat(0.0, "A wheel whose joint has lost one term."),
        Beat(share(0.5), "It leaves its hinge ..."),
        Beat(share(1.0), "... by 3.1 m in one turn, and no energy check would tell."),
    ),
    why="Plane motion has no w x I w, and a body placed by its centre of mass no m w x (w x s), so plane models never "
    "miss them. A model that drops a term passes one check and fails another: without w x I w the energy stays but the "
    "angular momentum turns, without m w x (w x s) an engine shakes a tenth less, without -J_dot v a wheel leaves its "
    "hinge, without H_dot a quaternion stops being a rotation.",
    equation="M v_dot + J^T lam = Q - w x I w - m w x (w x s); J v_dot = -J_dot v; e_ddot = (H w_dot + H_dot w) / 2",
    symbols={
        "M": Symbol("masses and moments"),
        "J": Symbol("rows of the joints"),
        "lam": Symbol("forces of the joints"),
        "Q": Symbol("other forces"),
        "v": Symbol("velocities"),
        "w": Symbol("turning", "rad/s"),
        "I": Symbol("moments", "kg m^2"),
        "m": Symbol("mass", "kg"),
        "s": Symbol("from the reference point to the centre of mass", "m"),
        "e": Symbol("quaternion"),
        "H": Symbol("what its rate is by w"),
        "T": Symbol("means transposed"),
    },
    source="closed forms for constant w, in the docstrings of the source",
    quantities={
        "energy_change_J": Quantity("no w x I w: change of energy, half a turn", "J", absolute=1e-10),
        "momentum_change_Nms": Quantity("no w x I w: change of angular momentum", "N m s", absolute=1e-10),
        "crank_1x_N": Quantity("no m w x (w x s): force of the crank, 1x (true: 10.966)", "N"),
        "hinge_gap_m": Quantity("no -J_dot v: gap of a hinge after one turn", "m"),
        **{f"gap_{name}_m": Quantity(f"1 mm gap after that time, {name}", "m", 1e-9, 1e-12)
           for name in ("none", "baumgarte", "projection")},
        "quaternion_deg": Quantity("no H_dot: angle of one turn (true: 360)", "deg"),
        "quaternion_length": Quantity("no H_dot: length of e (true: 1)"),
    },
    alone="its hinge is left on purpose",
    ablation=Ablation("forgetting", "with every term nothing breaks", {"terms": "kept"}),
    ranges={"I": [(1.0, 1.2), (1.9, 2.1), (2.7, 2.9)]},
    show={"curves": [("com", "wheel"), "drift"], "title": "without -J_dot v: the wheel leaves its hinge"},
)  # fmt: skip
