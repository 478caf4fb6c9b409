"""Verdicts do not depend on who looks: the same motion from a train, from afar, turned, mirrored, in other units."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from mbsd3d import (
    DOP853,
    GROUND,
    RK4,
    AngleDriver,
    Body,
    GeneralizedAlpha,
    RadauIIA,
    Revolute,
    Sine,
    Spherical,
    SpringDamper,
    System,
    TorsionSpring,
    rotation,
    simulate,
)
from mbsd3d.rotations import matrix

NAMES = "energy balance", "momentum balance", "angular momentum"
BODY_MIRROR = np.diag([1.0, -1.0, 1.0])  # body axes of a mirrored body are mirrored too
SKEW = matrix(rotation((0.3, -0.8, 0.5), 1.9))
METHODS = [RK4(0.04), DOP853(), RadauIIA(), GeneralizedAlpha(), GeneralizedAlpha(0.004)]


@dataclass(frozen=True)
class Observer:
    """Who measures lengths in metres over ``length`` and masses in kilograms over ``mass``, from a moving place."""

    speed: tuple = (0.0, 0.0, 0.0)
    place: tuple = (0.0, 0.0, 0.0)
    axes: np.ndarray = None
    length: float = 1.0
    mass: float = 1.0

    @property
    def Q(self):
        return np.eye(3) if self.axes is None else self.axes

    @property
    def hand(self):
        return float(np.linalg.det(self.Q))

    def point(self, x):
        return self.length * (self.Q @ np.asarray(x, float) + self.place)

    def velocity(self, v):
        return self.length * (self.Q @ v + self.speed)

    def axial(self, w):
        return self.hand * self.Q @ w

    def body(self, name, mass, inertia, com, position, turn):
        S = BODY_MIRROR if self.hand < 0 else np.eye(3)
        R = self.Q @ matrix(np.asarray(turn, float)) @ S
        I = S @ np.diag(inertia) @ S
        unit = self.mass * self.length**2
        return Body(name, self.mass * mass, unit * I, com=self.length * S @ np.asarray(com, float),
                    position=self.point(position), orientation=R)  # fmt: skip


PLACES = {"a": (0.1, 0.2, 0.3), "b": (0.9, 0.1, 0.2), "c": (1.3, -0.5, 0.4)}


def machine(o, held):
    """(system, state): three bodies on two hinges, one with a torsion spring and one driven, a spring across them all.

    Free in space and tumbling, or its first body held to the ground by a ball joint.
    """
    turns = [(0.8, 0.36, 0.48, 0.0), (0.6, 0.0, 0.64, 0.48), (0.28, 0.96, 0.0, 0.0)]
    given = [(2.0, (0.1, 0.2, 0.25)), (1.0, (0.05, 0.08, 0.06)), (0.7, (0.03, 0.05, 0.04))]
    coms = [(0.1, -0.05, 0.02), (0.02, 0.1, 0.05), (-0.06, 0.03, 0.08)]
    bodies = [o.body(n, m, i, c, PLACES[n], e) for n, (m, i), c, e in zip("abc", given, coms, turns, strict=True)]
    a, b, c = bodies
    first = Revolute(a, b, at=o.point((0.5, 0.2, 0.3)), axis=o.axial((0.3, 0.5, 1.0)), name="first")
    second = Revolute(b, c, at=o.point((1.1, -0.2, 0.3)), axis=o.axial((1.0, -0.4, 0.2)), name="second")
    unit = o.mass * o.length**2
    forces = [
        TorsionSpring(first, stiffness=6.0 * unit, damping=0.1 * unit, angle=0.4),
        SpringDamper(a, c, at_a=o.point((0.2, 0.5, 0.1)), at_b=o.point((1.4, -0.4, 0.7)), stiffness=20.0 * o.mass,
                     damping=0.2 * o.mass, length=1.1 * o.length),
    ]  # fmt: skip
    joints = [first, second, AngleDriver(second, Sine(0.7, 0.8), name="motor")]
    if held:
        joints.append(Spherical(GROUND, a, at=o.point((-0.2, 0.1, 0.4)), name="ball"))
    system = System(bodies, joints, forces, gravity=o.length * o.Q @ np.array([0.9, -0.4, -9.7]))
    return system, system.state()


def seen(o, held, method):
    """The run of a second as this observer sees it; velocities are those that the first one found."""
    known, start = machine(Observer(), held)
    v = start.v.reshape(3, 6).copy()
    if not held:
        spin = np.array([2.0, -3.0, 1.5])
        v[:, :3] += np.cross(spin, [PLACES[body.name] for body in known.bodies])
        v[:, 3:] += spin
    system, state = machine(o, held)
    there = np.hstack([[o.velocity(x) for x in v[:, :3]], [o.axial(x) for x in v[:, 3:]]])
    rtol = 1e-8 if method.dt else 1e-5
    return simulate(system, 1.0, state=replace(state, v=there.ravel()), method=method, rtol=rtol, output=41)


def ratios(run):
    """What the balances take of their limits."""
    return np.array([run.certificate[name].error / run.certificate[name].limit for name in NAMES])


TURNED = [
    Observer(place=(100.0, -30.0, 20.0)),
    Observer(axes=SKEW),
    Observer(axes=np.diag([1.0, 1.0, -1.0]) @ SKEW, place=(3.0, 4.0, -5.0)),
    Observer(length=1e3, mass=1e-3),  # millimetres and tonnes
    Observer(length=1e-3, mass=1e9, axes=SKEW),
]
BOOSTED = [Observer(speed=tuple(v * np.array([0.6, -0.64, 0.48]))) for v in (1e-3, 1.0, 30.0, 1e3)]
FAST = [Observer(speed=(0.48e4, 0.6e4, -0.64e4)), Observer(speed=(1e5, 0.0, 0.0), axes=SKEW, place=(7.0, 0.0, 9.0))]


@pytest.mark.parametrize("method", METHODS, ids=str)
@pytest.mark.parametrize("held", [True, False])
def test_the_place_the_axes_and_the_units_do_not_matter(held, method):
    base = ratios(seen(Observer(), held, method))
    # stages leave the hinges, and there the angles of springs and drivers depend on which perpendiculars mark them;
    # adaptive methods choose their first step by components of velocities, and with it all others
    alike = 0.04 if method.dt else 0.25
    for o in TURNED:
        assert ratios(seen(o, held, method)) == pytest.approx(base, rel=alike, abs=1e-6), o


@pytest.mark.parametrize("method", METHODS, ids=str)
def test_the_speed_of_the_observer_does_not_matter(method):
    base = ratios(seen(Observer(), False, method))
    for o in BOOSTED:
        assert ratios(seen(o, False, method)) == pytest.approx(base, rel=0.02, abs=1e-6), o


@pytest.mark.parametrize("method", METHODS, ids=str)
def test_from_the_speed_of_planets_only_rounding_differs(method):
    """Places are 1e5 m away at the end and have 1e-11 m as their last digit, so Newton's methods end there."""
    base = seen(Observer(), False, method)
    for o in FAST:
        run = seen(o, False, method)
        assert run.certificate.passed == base.certificate.passed
        assert ratios(run) == pytest.approx(ratios(base), rel=0.1, abs=0.02), o


def pair(o=Observer()):
    """Two bodies on a ball joint, tumbling freely."""
    given = [("a", 2.0, (0.1, 0.2, 0.25), (0.1, -0.05, 0.02), (0.1, 0.2, 0.3), (1.0, 0, 0, 0)),
             ("b", 1.0, (0.05, 0.08, 0.06), (0.0, 0.1, 0.05), (0.9, 0.3, 0.1), (0.8, 0.6, 0, 0))]  # fmt: skip
    a, b = (o.body(*x) for x in given)
    at = np.array([0.5, 0.25, 0.35])
    system = System([a, b], [Spherical(a, b, at=o.point(at))], gravity=(0, 0, 0))
    spins, at_joint = np.array([[3.0, -5.0, 2.0], [-2.0, 4.0, 6.0]]), np.array([0.4, 0.1, -0.3])
    places = np.array([x[4] for x in given])
    v = at_joint + np.cross(spins, places - at)
    there = np.hstack([[o.velocity(x) for x in v], [o.axial(x) for x in spins]])
    return system, replace(system.state(), v=there.ravel())


@pytest.mark.parametrize("speed", [0.0, 1.0, 1e2, 1e4])
def test_coarse_steps_fail_from_a_rocket_as_at_rest(speed):
    """They failed at rest, and passed at 1e4 m/s."""
    for place in ((0, 0, 0), (100.0, 20.0, -60.0)):
        system, state = pair(Observer(speed=(0.8 * speed, 0.0, 0.6 * speed), place=place))
        coarse, fine = (simulate(system, 2.0, state=state, method=RK4(dt), output=21) for dt in (0.05, 0.01))
        assert not coarse.certificate.passed and fine.certificate.passed
        assert not coarse.certificate["angular momentum"].passed


@pytest.mark.parametrize("switch", ["gyroscopic", "centripetal"])
@pytest.mark.parametrize("o", [Observer(), *BOOSTED[-1:], *FAST], ids=["rest", "plane", "rocket", "planet"])
def test_a_missing_term_fails_for_every_observer(switch, o):
    """By as much of its limit: at 1e5 m/s a momentum is known to 1e-10 of it, and the term is some 1e-1."""
    system, state = pair(o)
    run = simulate(system, 1.0, state=state, output=21, **{switch: False})
    failed = {check.name for check in run.certificate.checks if not check.passed}
    assert {"angular momentum", "Newton-Euler"} <= failed
