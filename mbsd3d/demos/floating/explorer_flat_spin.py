"""A long satellite that loses a little energy inside ends up tumbling end over end."""

import numpy as np

from mbsd3d import Body, Bushing, Spherical, System, shapes, simulate

from ..form import Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import first, share
from ..quadrature import motion

# [1] largest rate across the final axis over the rate about it: its square is lost in the rate
TRANSVERSE_RATE_RATIO_MAX = 1e-6
DOUBLINGS_MAX = 16  # [1] doublings of t, after which the satellite is given up
ROCKET_SHAPES = (shapes.Cylinder(0.25, 3.0, "x"), shapes.Cylinder(0.015, 2.2, "y", at=(0.6, 0, 0)))


def mechanism(*, I=(1.0, 9.0, 10.0), j=1.0, c=0.5, w=5.0, tilt=0.02) -> System:
    """Build a satellite I [kg m^2] spun at w [rad/s] about its least axis, tilt off; slug j [kg m^2] turning in c [N m
    s/rad].
    """
    omega = np.array([w, w * tilt, 0.0])
    body = Body("satellite", 10.0, I, omega=omega, shape=ROCKET_SHAPES)
    slug = Body("fuel", 1.0, (j, j, j), omega=omega, shape=shapes.Sphere(0.2, colour="orangered"))
    tank = Spherical(body, slug, at=(0, 0, 0), name="tank")
    viscous = Bushing(body, slug, at=(0, 0, 0), stiffness=0.0, turning_damping=c, name="viscous")
    return System([body, slug], [tank], [viscous], gravity=(0, 0, 0))


def own(times, I, j, c, w, tilt):
    """Integrate w of the satellite, b of the fuel: I w' + w x I w = c (b - w), j (b' + w x b) = -c (b - w), shape
    (times, 6).
    """

    def rate(_, y):
        w, b = y[:3], y[3:]
        slip = c * (b - w)
        return np.concatenate([(slip - np.cross(w, I * w)) / I, -slip / j - np.cross(w, b)])

    I, omega = np.asarray(I), np.array([w, w * tilt, 0.0])
    return motion(rate, np.concatenate([omega, omega]), times)


def theory(*, I, j, c, w, tilt, t):
    """Solve Euler's equations with the fuel; in the end all turns about the greatest axis with the same |H|."""
    require(I[2] >= max(I), f"demo 'explorer_flat_spin': I = {I}: the third moment must be the greatest; sort them")
    require(min(*I, j) > 0.01 * I[2], f"demo 'explorer_flat_spin': I = {I}, j = {j:g}: give none below 0.01 of I[2]")
    require(
        c > 0 and tilt != 0, "demo 'explorer_flat_spin': it tips only with losses and a tilt; give c > 0 and a tilt"
    )
    H = np.hypot((I[0] + j) * w, (I[1] + j) * w * tilt)
    rate = own(np.array([0.0, t]), I, j, c, w, tilt)[-1, 0]
    return {"long_axis_rate_at_t_rad_s": abs(rate), "final_flat_rate_rad_s": H / (I[2] + j)}


def measure(build, terms, *, I, j, c, w, tilt, t=40.0) -> Measured:
    """Measure the rate about the long axis at t, and of the whole when nothing moves inside any more."""
    run = simulate(build(), t, rtol=1e-13, output=401, **terms)
    later = run
    for _ in range(DOUBLINGS_MAX if c else 1):  # each as long as all before it: how soon it is calm nobody knows
        end = 2 * later.final.t
        later = later.again(end, state=later.final, output=[end])
        p, q, r = later.omega_body("satellite")[-1]
        if np.hypot(p, q) < TRANSVERSE_RATE_RATIO_MAX * abs(r):
            break
    x, known = run.omega_body("satellite")[:, 0], own(run.t, I, j, c, w, tilt)
    energy = run.energy().kinetic
    curve = Curve("rate about the long axis [rad/s]", run.t, x, (run.t, known[:, 0]))
    lost = Curve("kinetic energy [J]", run.t, energy, title="energy is lost, angular momentum is not")
    rate = float(np.linalg.norm(later.omega("satellite")[-1]))
    return Measured({"long_axis_rate_at_t_rad_s": abs(x[-1]), "final_flat_rate_rad_s": rate}, [run], [curve, lost])


demo = Demo(
    __name__,
    title="Explorer 1 and its flat spin",
    question="Why did Explorer 1, spun about its long axis, end up tumbling end over end?",
    beats=(
        Beat(0.0, "It spins about its long axis, like a bullet."),
        Beat(
            first(lambda run: np.abs(run.omega_body("satellite")[:, 0]) < 2.5),
            "Its fuel rubs: energy is lost, angular momentum is not.",
        ),
        Beat(share(1.0), "Now it tumbles end over end."),
    ),
    why="Nothing outside can change the angular momentum, but fuel that sloshes and aerials that bend turn energy "
    "into heat. For a given angular momentum the energy H^2/2I is greatest about the long axis, where I is "
    "least, and least about the short one. So the satellite tips, slowly at first, until it turns flat. A body "
    "without losses would have kept its spin.",
    equation="I w' + w x I w = c (b - w); j (b' + w x b) = -c (b - w); in the end: w = H / (I_3 + j)",
    symbols={
        "w": Symbol("spin about the long axis", "rad/s", curve=(0, 0)),
        "I": Symbol("moments of the satellite", "kg m^2"),
        "I_3": Symbol("greatest of them", "kg m^2", lambda I: I[2]),
        "b": Symbol("spin of the fuel", "rad/s"),
        "j": Symbol("moment of the fuel", "kg m^2", "j"),
        "c": Symbol("rubbing of the fuel", "N m s", "c"),
        "H": Symbol("angular momentum", "N m s", arrow="angular momentum"),
    },
    source="Hughes, Spacecraft Attitude Dynamics (energy sink, Explorer 1); Bracewell, Garriott, Nature 182 (1958)",
    quantities={
        "long_axis_rate_at_t_rad_s": Quantity("rate about the long axis at t", "rad/s", relative=1e-7),
        "final_flat_rate_rad_s": Quantity("rate of the flat spin in the end", "rad/s"),
    },
    ablation=Ablation(
        "losses", "with no friction inside it keeps spinning about its long axis", {"c": 0.0}, values=lambda: {}
    ),  # fmt: skip
    show={"curves": [("omega_body", "satellite"), "energy"], "shown": ["angular momentum"], "speed": 4.0, "traces": []},
    ranges={"I": [(0.9, 1.1), (8.5, 9.2), (9.25, 9.35)], "t": (30.0, 45.0)},
    sliders=(
        Control("c", 0.05, 1.0, "N m s", "losses", logarithmic=True),
        Control("w", 3.0, 6.0, "rad/s", "spin"),
    ),
    theory_moves=False,
    attempt="make the losses small: it spins about its long axis for longer, and ends flat all the same.",
)
