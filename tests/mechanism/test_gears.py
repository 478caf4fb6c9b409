"""Gears and tooth meshes against textbook forces, Willis' equation and rotor equations written here."""

import numpy as np
import pytest
from helpers.gears import ALPHA, BETA, R_A, R_B, Frame, rotor, torque

from mbsd3d import (
    GROUND,
    Body,
    Cylindrical,
    Gear,
    GearMesh,
    Planar,
    Revolute,
    System,
    accelerations,
    simulate,
)
from mbsd3d.mechanism.couplings import Axle
from mbsd3d.rotations import matrix

ROUNDING = 1e-10
"""Relative: forces of 1e3 N from saddle points of condition 1e4."""


I_A, I_B = 0.05, 0.4


def pair(torque_a, torque_b, *, inside=False, flank=1, mesh=True, helix=BETA, seed=1):
    """(frame, system, hinges, mesh): gears about z at x = 0 and R_A +- R_B of a general frame; P at x = R_A."""
    frame = Frame(seed)
    far = R_A - R_B if inside else R_A + R_B
    a = rotor("pinion", frame.at(0, 0, 0.05), frame.z, I_A)
    b = rotor("wheel", frame.at(far, 0, -0.04), frame.z, I_B)
    first = Revolute(GROUND, a, at=frame.at(0, 0, -0.2), axis=frame.z, name="first")
    second = Revolute(GROUND, b, at=frame.at(far, 0, 0.3), axis=frame.z, name="second")
    if mesh:
        teeth = GearMesh(
            first, second, at=frame.at(R_A, 0, 0.1), pressure_angle=ALPHA, helix_angle=helix, flank=flank, name="teeth"
        )
    else:
        teeth = Gear(first, second, ratio=(1 if inside else -1) * R_A / R_B, name="teeth")
    loads = [torque(a, frame.z, torque_a), torque(b, frame.z, torque_b)]
    return (
        frame,
        System([a, b], [first, second, teeth], loads, gravity=frame.to(0.4, -0.7, -9.6)),
        (first, second),
        teeth,
    )


def tangential(torque_a, torque_b, sign):
    """(F_t on the wheel along +y, angular acceleration of the pinion) of two rotors, w_b = sign r_a/r_b w_a."""
    i = sign * R_A / R_B
    alpha = (torque_a + i * torque_b) / (I_A + i**2 * I_B)
    return (torque_a - I_A * alpha) / R_A, alpha


@pytest.mark.parametrize("inside", [False, True], ids=["external", "internal"])
@pytest.mark.parametrize("helix", [0.0, BETA])
def test_a_mesh_may_be_told_from_either_gear(inside, helix):
    """Action and reaction along one line; the helices of an internal mesh have one hand, those of others two."""
    _, _, (first, second), teeth = pair(1.0, 1.0, inside=inside, helix=helix)
    turned = helix if inside else -helix
    other = GearMesh(second, first, at=teeth.at, pressure_angle=ALPHA, helix_angle=turned, flank=-1 if inside else 1)
    assert other.direction() == pytest.approx(-teeth.direction(), abs=1e-14)


@pytest.mark.parametrize("inside", [False, True], ids=["external", "internal"])
@pytest.mark.parametrize("balanced", [True, False], ids=["steady", "accelerating"])
def test_tooth_force_of_helical_gears_is_that_of_the_textbook(inside, balanced):
    sign = 1 if inside else -1
    torque_b = -sign * 40.0 * R_B / R_A if balanced else -sign * 31.0
    # positive torque on the pinion drives the wheel along +y at P: forwards inside, backwards outside
    frame, system, (first, second), teeth = pair(40.0, torque_b, inside=inside, flank=sign)
    found = accelerations(system)
    F_t, alpha = tangential(40.0, torque_b, sign)
    assert (abs(alpha) < 1e-12) == balanced
    # away from the pinion: an external pinion is pressed towards its axis; right-handed pinion: its trace leans to +y
    expected = [F_t * np.tan(ALPHA) / np.cos(BETA), F_t, -F_t * np.tan(BETA)]
    reaction = found.reaction(teeth)
    assert frame.local(reaction.force[0]) == pytest.approx(expected, rel=ROUNDING)
    assert reaction.point[0] == pytest.approx(frame.at(R_A, 0, 0.1), abs=1e-14)
    assert np.abs(reaction.moment).max() < ROUNDING * F_t  # a force through the pitch point, no couple
    assert teeth.normal_force(found)[0] == pytest.approx(F_t / np.cos(ALPHA) / np.cos(BETA), rel=ROUNDING)
    assert found.alpha("pinion")[0] == pytest.approx(alpha * frame.z, abs=1e-9)
    assert found.alpha("wheel")[0] == pytest.approx(sign * R_A / R_B * alpha * frame.z, abs=1e-9)
    assert teeth.ratio == pytest.approx(sign * R_A / R_B, rel=1e-14)
    # the bearings carry what the teeth do: statics of each shaft, weight apart
    for hinge, side, arm in ((second, 1, (sign * R_B if inside else -R_B, 0, -0.2)), (first, -1, (R_A, 0, 0.3))):
        weight = 1.3 * frame.local(system.gravity)
        centre = (0, 0, -0.34) if side == 1 else (0, 0, 0.25)
        held = found.reaction(hinge)
        assert frame.local(held.force[0]) == pytest.approx(-side * np.array(expected) - weight, abs=ROUNDING * F_t)
        moment = -np.cross(arm, side * np.array(expected)) - np.cross(centre, weight)
        # about the axis the hinge carries none
        assert frame.local(held.moment[0])[:2] == pytest.approx(moment[:2], abs=ROUNDING * F_t)
        assert abs(held.moment[0] @ frame.z) < ROUNDING * F_t


def test_other_flank_turns_the_radial_force():
    """With the torque reversed the other flanks touch: the force still parts the gears."""
    frame, system, _, teeth = pair(-40.0, -31.0, flank=1)
    F_t = tangential(-40.0, -31.0, -1)[0]
    force = frame.local(accelerations(system).reaction(teeth).force[0])
    assert F_t < 0 and force == pytest.approx(
        [abs(F_t) * np.tan(ALPHA) / np.cos(BETA), F_t, -F_t * np.tan(BETA)], rel=ROUNDING
    )
    wrong = pair(-40.0, -31.0, flank=-1)
    assert wrong[3].normal_force(accelerations(wrong[1]))[0] < 0  # and says so


def test_gear_moves_as_the_mesh_does_and_loads_no_bearing():
    moving = [pair(40.0, 31.0, mesh=mesh) for mesh in (True, False)]
    runs = [simulate(system, 0.3, rtol=1e-11, output=7) for _, system, *_ in moving]
    for name in ("pinion", "wheel"):
        assert runs[0].omega(name) == pytest.approx(runs[1].omega(name), abs=1e-7)  # of 100 rad/s
    frame, system, (_, second), teeth = moving[1]
    still = runs[1].reaction(second).force + 1.3 * system.gravity
    assert np.abs(still).max() < 1e-8  # 40 N m through the couple only
    assert np.abs(runs[1].reaction(teeth).force).max() < 1e-8
    # the mesh's force stands still in space while the gears turn
    force, point = runs[0].reaction(moving[0][3]).force, runs[0].reaction(moving[0][3]).point
    assert np.ptp(force, axis=0).max() < 1e-7 and np.ptp(point, axis=0).max() == 0.0
    assert runs[0].certificate.passed


def test_ablation_one_per_cent_of_an_angle_is_seen():
    change = np.tan(1.01 * ALPHA) / np.tan(ALPHA) - 1.0
    assert change > 100 * ROUNDING


def test_a_helical_gear_that_slides_turns():
    """Its material moves along the trace of a fixed right-handed pinion: by s along z and s tan(beta) along y."""
    frame, system, (_, second), _ = pair(0.0, 0.0)
    pinion, wheel = system.bodies
    loose = Cylindrical(GROUND, wheel, at=second.at, axis=frame.z)
    held = Revolute(GROUND, pinion, at=frame.at(0, 0, -0.2), axis=frame.z)
    mesh = GearMesh(held, loose, at=frame.at(R_A, 0, 0.1), pressure_angle=ALPHA, helix_angle=BETA)
    moved = System([pinion, wheel], [held, loose, mesh]).assemble(slides={loose: 0.03}, angles={held: 0.0})
    turned = matrix(moved.q[10:]) @ matrix(wheel.orientation).T
    turn = -0.03 * np.tan(BETA) / R_B
    assert frame.R.T @ turned @ frame.x == pytest.approx([np.cos(turn), np.sin(turn), 0.0], abs=1e-12)  # assembled


DELTA = np.radians(34.0)


SHAFTS = np.radians(81.0)


def bevel(spiral):
    """(frame, axes, bodies, hinges, mesh): cones of half angles DELTA and SHAFTS - DELTA; apex at the origin."""
    frame = Frame(3)
    u_a, u_b = frame.to(0, 0, 1), frame.to(np.sin(SHAFTS), 0, np.cos(SHAFTS))
    a, b = rotor("pinion", frame.at(0, 0, 0.5), u_a, I_A), rotor("crown wheel", frame.origin + 0.4 * u_b, u_b, I_B)
    first = Revolute(GROUND, a, at=frame.at(0, 0, 0.6), axis=u_a)
    second = Revolute(b, GROUND, at=frame.origin + 0.3 * u_b, axis=u_b)  # the wheel is body a of its hinge
    at = frame.at(0.5 * np.sin(DELTA), 0, 0.5 * np.cos(DELTA))
    mesh = GearMesh(first, second, at=at, pressure_angle=ALPHA, helix_angle=spiral, flank=1)
    return frame, (u_a, u_b), (a, b), (first, second), mesh


@pytest.mark.parametrize("spiral", [0.0, np.radians(30.0)])
def test_bevel_gears(spiral):
    frame, (u_a, u_b), (a, b), hinges, mesh = bevel(spiral)
    r_a, r_b = 0.5 * np.sin(DELTA), 0.5 * np.sin(SHAFTS - DELTA)
    # flank 1 pushes the wheel forwards about u_b, at P along -y, so the pinion's torque is negative
    load = r_b / r_a * 25.0
    system = System([a, b], [*hinges, mesh], [torque(a, u_a, -25.0), torque(b, u_b, -load)], gravity=(0, 0, 0))
    found = accelerations(system)
    assert max(np.abs(found.alpha(x)).max() for x in (a, b)) < 1e-9  # balanced
    F_t = 25.0 / r_a
    on_pinion = frame.local(-found.reaction(mesh).force[0])
    # the force meets a right-handed pinion turning clockwise, seen from the apex, as Gleason's formulas have it:
    # F_r, F_a = F_t / cos(spiral) (tan(alpha) cos(delta) +- sin(spiral) sin(delta), tan sin -+ sin cos)
    k, s = np.tan(ALPHA) / np.cos(spiral), np.tan(spiral)
    radial = F_t * (k * np.cos(DELTA) + s * np.sin(DELTA))
    axial = F_t * (k * np.sin(DELTA) - s * np.cos(DELTA))
    assert on_pinion == pytest.approx([-radial, F_t, axial], rel=ROUNDING, abs=ROUNDING * F_t)
    assert mesh.ratio == pytest.approx(-r_a / r_b, rel=1e-13)  # hinge rates of the gears relative to the ground


def test_crossed_helical_gears():
    """Ratio r_a cos(beta_a) / (r_b cos(beta_b)) with beta_a + beta_b the shaft angle (both of one hand)."""
    frame, shafts, beta_a = Frame(4), np.radians(70.0), np.radians(25.0)
    beta_b = shafts - beta_a
    u_a = frame.z
    # about the common normal x: the trace of a right-handed a leans by beta_a from u_a towards +y, u_b lies beyond it
    u_b = frame.to(0, np.sin(shafts), np.cos(shafts))
    a = rotor("worm", frame.at(0, 0, 0.1), u_a, I_A)
    b = rotor("worm wheel", frame.at(R_A + R_B, 0, 0) + 0.2 * u_b, u_b, I_B)
    first = Revolute(GROUND, a, at=frame.at(0, 0, 0.3), axis=u_a)
    second = Revolute(GROUND, b, at=frame.at(R_A + R_B, 0, 0) - 0.1 * u_b, axis=u_b)
    mesh = GearMesh(first, second, at=frame.at(R_A, 0, 0), pressure_angle=ALPHA, helix_angle=beta_a, flank=-1)
    ratio = -R_A * np.cos(beta_a) / (R_B * np.cos(beta_b))
    assert mesh.ratio == pytest.approx(ratio, rel=1e-13)
    system = System(
        [a, b], [first, second, mesh], [torque(a, u_a, 25.0), torque(b, u_b, -25.0 / ratio)], gravity=(0, 0, 0)
    )
    found = accelerations(system)
    assert max(np.abs(found.alpha(x)).max() for x in (a, b)) < 1e-8
    F_t = 25.0 / R_A
    force = frame.local(found.reaction(mesh).force[0])
    assert force == pytest.approx([F_t * np.tan(ALPHA) / np.cos(beta_a), F_t, -F_t * np.tan(beta_a)], rel=1e-9)


@pytest.mark.parametrize("hand", [1, -1], ids=["right-handed", "left-handed"])
def test_hypoid_gears(hand):
    """Cones built outwards from the pitch plane y = 0 at the origin; `GearMesh` sees their axes and the point only.

    Elements at an angle eta = beta_a - beta_b to each other: radii r_a cos(beta_a) : r_b cos(beta_b) = ratio, offset
    (r_a cos(delta_b) + r_b cos(delta_a)) sin(eta)/sin(shafts); each thrust as of a bevel gear with its own numbers.
    """
    frame, r_a, r_b = Frame(5), 0.04, 0.13
    beta_a, beta_b = hand * np.radians(47.0), hand * np.radians(31.0)
    delta_a, delta_b, eta = np.radians(16.0), np.radians(68.0), beta_a - beta_b
    g_a, g_b, y = np.array([0, 0, 1.0]), np.array([-np.sin(eta), 0, np.cos(eta)]), np.array([0, 1.0, 0])
    # gear a lies below the plane, b above it; their axes meet the elements in the apexes
    u_a, u_b = np.cos(delta_a) * g_a - np.sin(delta_a) * y, np.cos(delta_b) * g_b + np.sin(delta_b) * y
    tips = [-r_a / np.sin(delta_a) * g_a, -r_b / np.sin(delta_b) * g_b]
    across = np.cross(u_a, u_b)
    offset = (r_a * np.cos(delta_b) + r_b * np.cos(delta_a)) * np.sin(abs(eta)) / np.linalg.norm(across)
    assert abs((tips[1] - tips[0]) @ across) / np.linalg.norm(across) == pytest.approx(offset, rel=1e-12)
    bodies, hinges = [], []
    for name, tip, axis, spin in (("pinion", tips[0], u_a, I_A), ("crown wheel", tips[1], u_b, I_B)):
        bodies.append(rotor(name, frame.at(*(tip + 0.07 * axis)), frame.to(*axis), spin))
        hinges.append(Revolute(GROUND, bodies[-1], at=frame.at(*(tip - 0.02 * axis)), axis=frame.to(*axis)))
    mesh = GearMesh(*hinges, at=frame.origin, pressure_angle=ALPHA, helix_angle=beta_a)
    ratio = -r_a * np.cos(beta_a) / (r_b * np.cos(beta_b))
    assert mesh.ratio == pytest.approx(ratio, rel=1e-12)
    loads = [torque(bodies[0], frame.to(*u_a), -25.0), torque(bodies[1], frame.to(*u_b), 25.0 / ratio)]
    found = accelerations(System(bodies, [*hinges, mesh], loads, gravity=(0, 0, 0)))
    assert max(np.abs(found.alpha(body)).max() for body in bodies) < 1e-9  # balanced
    force = frame.local(found.reaction(mesh).force[0])
    F_n = 25.0 / r_a / (np.cos(beta_a) * np.cos(ALPHA))
    assert mesh.normal_force(found)[0] == pytest.approx(F_n, rel=ROUNDING)
    k, across_a, across_b = np.sin(ALPHA), np.cos(ALPHA) * np.sin(beta_a), np.cos(ALPHA) * np.sin(beta_b)
    thrust_a = F_n * (k * np.sin(delta_a) - across_a * np.cos(delta_a))
    thrust_b = F_n * (k * np.sin(delta_b) + across_b * np.cos(delta_b))
    assert [-force @ u_a, force @ u_b] == pytest.approx([thrust_a, thrust_b], rel=ROUNDING)
    slip = np.cross(u_b * ratio, -tips[1]) - np.cross(u_a, -tips[0])  # along the teeth, per rate of the pinion
    assert slip @ force == pytest.approx(0.0, abs=1e-12 * F_n)
    assert np.linalg.norm(slip) == pytest.approx(r_a * np.sin(abs(eta)) / np.cos(beta_b), rel=1e-12)


@pytest.mark.parametrize("turned", [False, True], ids=["gear is b", "gear is a"])
def test_a_gear_built_out_of_line_is_assembled_and_pushed_along_the_same_line(turned):
    """The hub of the wheel is where its hinge says: the force stays one force through the pitch point."""
    frame, system, (first, second), _ = pair(40.0, -31.0)
    pinion, wheel = system.bodies
    hub, spin = second.at + frame.to(0.004, -0.007, 0.005), frame.to(0.02, -0.03, 1.0)
    if turned:
        odd = Revolute(wheel, GROUND, at=hub, axis=spin, at_b=second.at, axis_b=frame.z)
    else:
        odd = Revolute(GROUND, wheel, at=second.at, axis=frame.z, at_b=hub, axis_b=spin)
    teeth = GearMesh(first, odd, at=frame.at(R_A, 0, 0.1), pressure_angle=ALPHA, helix_angle=BETA)
    built = System([pinion, wheel], [first, odd, teeth], system.forces)
    found = accelerations(built, built.assemble(angles={first: 0.3}, rates={first: 5.0}))
    F_n = teeth.normal_force(found)[0]
    assert abs(F_n) > 100.0
    assert found.reaction(teeth).force[0] == pytest.approx(F_n * teeth.direction(), abs=ROUNDING * abs(F_n))
    assert np.abs(found.reaction(teeth).moment).max() < 1e-8 * abs(F_n)  # assembled to 1e-9
    n = frame.to(np.sin(ALPHA), -np.cos(ALPHA) * np.cos(BETA), np.cos(ALPHA) * np.sin(BETA))
    assert teeth.direction() == pytest.approx(n, abs=1e-12)  # by the axes as the carrier has them
    assert abs(teeth.ratio) == pytest.approx(R_A / R_B, rel=1e-12)


def test_errors_of_gear_meshes():
    frame, system, (first, second), _ = pair(1.0, 1.0)
    b, at = system.bodies[1], frame.at(R_A, 0, 0)
    far, third = (Body(name, 1.0, (1, 1, 1)) for name in ("far", "third"))
    flat = Planar(GROUND, b, at=frame.at(1, 0, 0), normal=frame.z, name="flat")
    cases = [
        (dict(hinge_b=flat), "'flat' is a Planar; give a Revolute"),
        (dict(hinge_b=Revolute(far, third, at=at, axis=frame.z, name="far hinge")), "share no body; give carrier="),
        (dict(at=frame.at(0, 0, 0.3)), "lies on an axis"),
        (dict(hinge_b=Revolute(GROUND, b, at=frame.at(0.3, 0.1, 0), axis=frame.z)), "are parallel, so it must lie in"),
        (dict(hinge_b=Revolute(GROUND, b, at=frame.at(0, 0, 0.4), axis=frame.to(2, 1, 0))), "they meet, so it must"),
        (
            dict(hinge_b=Revolute(GROUND, b, at=frame.at(0.3, 0, 0.2), axis=frame.to(0, 1e-3, 1))),
            "nearly one direction",
        ),
        (dict(pressure_angle=20.0), "give radians"),
        (dict(flank=0), "flank 0 is unknown; give 1 or -1"),
        (dict(hinge_b=Revolute(far, GROUND, at=at, axis=frame.z, name="end"), carrier=third), "'end' is the ground"),
        (dict(carrier="arm"), "carrier = 'arm' is not a body"),
    ]
    for fields, message in cases:
        with pytest.raises(ValueError, match=message) as caught:
            GearMesh(**{"hinge_a": first, "hinge_b": second, "at": at, "name": "teeth", **fields})
        assert "teeth" in str(caught.value)
    with pytest.raises(ValueError, match="flat crown wheel"):
        cone = Revolute(GROUND, b, at=frame.at(0, 0, 0), axis=frame.to(1, 0, 0.4))
        GearMesh(first, cone, at=at, name="teeth")


def test_axle_arm_is_at_right_angles():
    frame = Frame(8)
    arm = Axle(frame.at(0, 0, 3.0), frame.z).arm(frame.at(0.3, -0.4, 1.0))
    assert frame.local(arm) == pytest.approx([0.3, -0.4, 0.0], abs=1e-14)
