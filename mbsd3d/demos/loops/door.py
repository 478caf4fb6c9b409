"""A door on two hinges: ten rows of rank five, a determined motion and undetermined shares of the load."""

import numpy as np
from scipy.special import ellipj, ellipk

from mbsd3d import GROUND, Body, PointOnLine, Revolute, Spherical, System, inertia, rotation, shapes, simulate
from mbsd3d.base.rotations import matrix
from mbsd3d.base.style import GREY

from ..base import YES_OR_NO
from ..figure import Line
from ..form import GRAVITY, Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require

G, SAMPLES = 9.81, 301


def mechanism(*, m=20.0, width=0.9, thickness=0.04, height=2.0, lean_deg=5.0, start_deg=60.0, hinges=0.7,
              fit="two hinges") -> System:  # fmt: skip
    """Build a door of m [kg] and a size [m], its hinge axis leaning towards x, open by an angle, hinges at +-
    ``hinges`` [m].

    Two revolute hinges, or (``fit`` = "cured") a ball above and a point on a line below. Reference point on the axis.
    """
    require(fit in ("two hinges", "cured"), f"demo 'door': fit = {fit!r}; give 'two hinges' or 'cured'")
    require(hinges != 0, "demo 'door': hinges = 0: two hinges in one place are one; give a distance")
    lean = np.radians(lean_deg)
    axis = np.array([np.sin(lean), 0.0, np.cos(lean)])
    turned = matrix(rotation("y", lean)) @ matrix(rotation("z", np.radians(start_deg)))
    size = (width, thickness, height)
    form = shapes.Box(size), shapes.Cylinder(0.015, 0.2, "y", at=(0.93 * width, 0, 0), colour=GREY)
    leaf = Body("door", m, inertia.box(m, size), com=(width / 2, 0, 0), orientation=turned, shape=form)
    top, bottom = {"at": hinges * axis, "name": "top"}, {"at": -hinges * axis, "axis": axis, "name": "bottom"}
    if fit == "cured":
        return System([leaf], [Spherical(GROUND, leaf, **top), PointOnLine(GROUND, leaf, **bottom)], gravity=(0, 0, -G))
    joints = [Revolute(GROUND, leaf, axis=axis, **top), Revolute(GROUND, leaf, **bottom)]
    return System([leaf], joints, gravity=(0, 0, -G))


def swing(t, *, m, width, thickness, lean_deg, start_deg):
    """Return the angle from the rest [rad] after the release, sin(angle/2) = k cd(p t | k^2), and (times, 3) force of
    both hinges together [N]: m (a - g), a on the circle of the centre of mass.
    """
    lean, lever, k = np.radians(lean_deg), width / 2, np.sin(np.radians(start_deg) / 2)
    p2 = G * np.sin(lean) * lever / (width**2 / 3 + thickness**2 / 12)
    sn, cn, dn, _ = ellipj(np.sqrt(p2) * np.asarray(t, float) + ellipk(k * k), k * k)
    angle, rate2 = 2 * np.arcsin(k * sn), 4 * k**2 * p2 * cn**2
    out = np.outer(np.cos(angle), [np.cos(lean), 0, -np.sin(lean)]) + np.outer(np.sin(angle), [0, 1, 0])
    around = np.cross([np.sin(lean), 0, np.cos(lean)], out)
    a = lever * (-(p2 * np.sin(angle))[:, None] * around - rate2[:, None] * out)
    return angle, m * (a + [0, 0, G])


def theory(*, m, width, thickness, lean_deg, start_deg, fit, t):
    """Return count and rank of ten rows; a physical pendulum for the motion, Newton's second law for the net force."""
    require(0 < abs(start_deg) < 180 and 0 < lean_deg < 90, "demo 'door': give 0 < lean_deg < 90 and an angle to swing")
    require(fit == "two hinges", "demo 'door': the cured door is computed beside the other; leave fit = 'two hinges'")
    angle, force = swing([t / 3, t], m=m, width=width, thickness=thickness, lean_deg=lean_deg, start_deg=start_deg)
    named = {f"net_force_{axis}_N": value for axis, value in zip("xyz", force[0], strict=True)}
    counts = {"rows": 10, "rank": 5, "gruebler": -4, "mobility": 1, "net_unique": 1, "share_unique": 0}
    carried = m * G * np.cos(np.radians(lean_deg))
    return {**counts, "cured_redundant": 0, "angle_rad": angle[1], **named, "cured_top_along_N": carried}


def angle_of(run, lean):
    """Return the angle from the rest [rad]."""
    out = run.rotation("door")[:, :, 0]
    return np.arctan2(out[:, 1], out @ [np.cos(lean), 0, -np.sin(lean)])


def measure(build, terms, *, m, width, thickness, lean_deg, start_deg, t=6.0) -> Measured:
    """Measure the door as built and with its remedy: results of `check`, angle at t, forces at t/3."""
    doors = build(), build(fit="cured")
    built, cured = (simulate(door, t, rtol=1e-11, output=SAMPLES, **terms) for door in doors)
    (found, remedied), net = (door.check() for door in doors), built.reaction("top", "bottom")
    third, lean = (SAMPLES - 1) // 3, np.radians(lean_deg)
    along = built.reaction("top").force @ [np.sin(lean), 0, np.cos(lean)]
    kept = cured.reaction("top").force @ [np.sin(lean), 0, np.cos(lean)]
    values = {
        "rows": found.rows, "rank": found.rank, "gruebler": found.gruebler, "mobility": found.mobility,
        "net_unique": float(net.unique), "share_unique": float(built.reaction("top").unique),
        "cured_redundant": remedied.redundant, "angle_rad": angle_of(built, lean)[-1],
        **{f"net_force_{axis}_N": net.force[third, k] for k, axis in enumerate("xyz")}, "cured_top_along_N": kept[-1],
    }  # fmt: skip
    known, force = swing(built.t, m=m, width=width, thickness=thickness, lean_deg=lean_deg, start_deg=start_deg)
    bare, known_bare = net.force - [0, 0, m * G], force - [0, 0, m * G]
    lines = [Line(name, bare[:, k], theory=(built.t, known_bare[:, k]))
             for k, name in enumerate(("x", "y", "z, less the weight"))]  # fmt: skip
    outwards = np.einsum("ti,ti->t", built.reaction("top").force, built.rotation("door")[:, :, 0])
    curves = [
        Curve("angle from the rest [deg]", built.t, np.degrees(angle_of(built, lean)),
              (built.t, np.degrees(known)), title="the motion is certain"),
        Curve("force of both hinges on the door [N]", built.t, lines[0].y, lines[0].theory, name="x", more=lines[1:],
              title="so is the force of both hinges together"),
        Curve("force of the top hinge on the door [N]", built.t, along, name="along the axis",
              title="what one hinge carries is not", more=[Line("outwards", outwards)]),
    ]  # fmt: skip
    notes = [f"assessment: {found.verdict}", *(f"remedy: {cure.text}" for cure in found.cures)]
    return Measured(values, [built, cured], curves, notes=notes)


demo = Demo(
    __name__,
    title="Two-hinge door: redundant, and still certain",
    question="Why does a door turn on two hinges although counting says it cannot?",
    beats=(
        Beat(0.0, "The arrows are the forces of the hinges."),
        Beat(1.42, "Shut, and it swings on: the motion is certain."),
        Beat(2.8, "So is the sum of both forces. Pale: how they share it nobody can know."),
    ),
    why="In a plane a hinge takes two degrees of freedom of three and a second one locks the door. In space five of "
    "six go, and a second hinge on the same axis takes the same five again, so counting says 6 - 10 = -4 where the "
    "door turns. Its motion is certain, and so is the force of both hinges together. What each of them carries is not: "
    "it depends on how they were fitted. With a ball above and a point on a line below, each share is unique.",
    equation="6 - 10 = -4 by counting, 6 - rank = 1; sin(a/2) = k cd(p t, k^2); F = m (a - g)",
    symbols={
        "a": Symbol("in the second formula the opening; in the third the acceleration", "rad", curve=(0, 0)),
        "F": Symbol("force of both hinges; here the upper one", "N", curve=(1, 0), arrow="reaction force"),
        "m": Symbol("door", "kg", "m"),
        "g": GRAVITY,
        "k": Symbol("sine of half the greatest opening"),
        "p": Symbol("rate of small swings", "rad/s"),
        "t": Symbol("time", "s"),
    },
    source="physical pendulum by elliptic functions; the net force by Newton's second law, m (a - g)",
    quantities={
        "rows": Quantity("rows of the joints"),
        "rank": Quantity("rank: independent rows"),
        "gruebler": Quantity("Gruebler's count 6 - rows"),
        "mobility": Quantity("mobility 6 - rank"),
        "cured_redundant": Quantity("redundant rows with the remedy"),
        "angle_rad": Quantity("angle from the rest at t", "rad"),
        **{f"net_force_{axis}_N": Quantity(f"both hinges together, force {axis} at t/3", "N", absolute=1e-8)
           for axis in "xyz"},
        "cured_top_along_N": Quantity("cured: top hinge, along the axis", "N", absolute=1e-8),
        "net_unique": Quantity("the net force is unique", YES_OR_NO),
        "share_unique": Quantity("the share of one hinge is unique", YES_OR_NO),
    },
    ablation=Ablation("redundancy", "counting is right, and every share is certain", {"fit": "cured"},
                      lambda: {"rows": 5, "rank": 5, "gruebler": 1, "mobility": 1, "net_unique": 1, "share_unique": 1}),
    show={"curves": [("angle", "top"), ("reaction", "top", "bottom")], "shown": ["reaction force"], "traces": []},
    sliders=(
        Control("lean_deg", 1.0, 20.0, "deg", "lean of the hinges"),
        Control("start_deg", 20.0, 90.0, "deg", "opened by"),
    ),
    attempt="let it lean more: it swings faster, and the hinges bear more.",
)  # fmt: skip
