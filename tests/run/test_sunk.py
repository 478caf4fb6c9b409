"""What starts deep in the ground is refused, by its name, with the sizes that do not fit each other."""

from dataclasses import replace

import numpy as np
import pytest

from mbsd3d import GROUND, Body, Contact, Revolute, System, Tyre, accelerations, rotation, shapes, simulate
from mbsd3d.rotations import matrix, quaternion_from_matrix

NORMAL = np.array([0.2, -0.1, 1.0]) / np.linalg.norm((0.2, -0.1, 1.0))
AT = np.array([0.4, -0.3, 0.2])  # of a slope


def leaning_wheel(radius, height=0.31, slope=GROUND):
    """On a slope, its centre of mass beside its hub."""
    hub = AT + height * NORMAL + (0.1, 0.2, 0.0)  # 0.2 0.1 - 0.1 0.2 = 0: along the slope
    turn = rotation((1, 0.3, 0.1), 0.3)
    body = Body("wheel", 6.0, (0.2, 0.3, 0.2), position=hub, com=(0.02, 0.01, 0.03), orientation=turn)
    tyre = Tyre(
        slope, body, axis=body.axes[:, 1], radius=radius, crown=0.04, stiffness=4e4, centre=hub, plane=(AT, NORMAL),
        name="tyre",
    )  # fmt: skip
    return System([part for part in (slope, body) if part is not GROUND], forces=[tyre])


def test_a_radius_in_millimetres_is_refused_at_the_start():
    """At 330 m of radius the wheel would be thrown 3 km high, with a certificate that passes."""
    assert accelerations(leaning_wheel(0.33)).force("tyre").normal[0] > 0.0
    for run in (accelerations, lambda system: simulate(system, 0.1)):
        with pytest.raises(ValueError, match=r"'tyre' .Tyre.: 'wheel' starts 3.* m deep in the plane.*size .in m"):
            run(leaning_wheel(330.0))


def test_a_wheel_may_be_pressed_deep_but_not_up_to_its_hub():
    assert accelerations(leaning_wheel(0.33, 0.1)).force("tyre").normal[0] > 7e3
    with pytest.raises(ValueError, match="starts 0.3.* m deep"):
        accelerations(leaning_wheel(0.33, 0.0))


def test_it_is_the_start_that_counts():
    """A reference pose in the ground does not matter."""
    system = leaning_wheel(0.33, -1.0)
    raised = system.state().q.copy()
    raised[:3] += 1.3 * NORMAL
    assert accelerations(system, replace(system.state(), q=raised)).force("tyre").normal[0] > 0.0


def test_a_slope_that_was_moved_takes_its_ground_along():
    """A bank with a wheel on it, both turned and shifted as one: what starts deep is what did before."""
    turn, shift = rotation((0.4, -1.0, 0.7), 2.1), np.array([3.0, -5.0, 8.0])
    bank = Body("bank", 50.0, (5.0, 6.0, 7.0), position=(0.3, 0.1, -0.4))
    for height, deep in ((0.31, False), (0.0, True)):
        system = leaning_wheel(0.33, height, slope=bank)
        q = system.state().q.reshape(2, 7).copy()
        for pose in q:
            pose[:3], pose[3:] = (
                matrix(turn) @ pose[:3] + shift,
                quaternion_from_matrix(matrix(turn) @ matrix(pose[3:])),
            )
        moved = replace(system.state(), q=q.ravel())
        if deep:
            with pytest.raises(ValueError, match="starts 0.3.* m deep"):
                accelerations(system, moved)
        else:
            known = accelerations(system).force("tyre").normal[0]
            # 4e4 N/m times the rounding of places 10 m away
            assert accelerations(system, moved).force("tyre").normal[0] == pytest.approx(known, abs=1e-9)


def stone(size, stiffness=1e4):
    """An egg above or in a slope, its centre of mass beside the middle of its surface."""
    turn = rotation((0.3, 1, 0.2), 0.4)
    body = Body("stone", 1.0, (0.1, 0.2, 0.25), position=AT + 0.35 * NORMAL, com=(0.05, 0.02, 0.1), orientation=turn)
    egg = shapes.Ellipsoid((0.4 * size, 0.5 * size, 0.6 * size), at=(0, 0, 0), orientation=rotation("x", 0.4))
    floor = Contact(GROUND, body, egg, stiffness=stiffness, damping=3.0, plane=(AT, NORMAL), name="floor")
    return System([body], forces=[floor])


def test_a_surface_in_millimetres_is_refused_as_built():
    """At 580 m it would be thrown out at 58 km/s, with a certificate that passes."""
    assert accelerations(stone(1.0)).acceleration("stone")[0, 2] > -9.81
    with pytest.raises(ValueError, match=r"force 'floor' .Contact.: 'stone' starts 579\.5 m deep.*size .in m"):
        simulate(stone(1e3), 0.1)


def test_a_soft_contact_may_sink():
    """As built where it carries some weights at most, and from the state of a run in any case."""
    soft = stone(1.0, 10.0)
    fall = simulate(soft, 0.5)
    again = simulate(stone(1.0, 1e4), 0.51, state=fall.final)
    assert NORMAL @ (fall.position("stone")[-1] - AT) < 0.0 and again.certificate.passed
    deep = replace(soft.bodies[0], position=AT - 0.1 * NORMAL)
    floor = replace(soft.forces[0], b=deep)
    assert simulate(System([deep], forces=[floor]), 0.1).certificate.passed
    with pytest.raises(ValueError, match="'floor' .Contact.: 'stone' starts"):
        accelerations(System([deep], forces=[replace(floor, stiffness=1e3)]))


def buffered(radius=0.03, arm=0.6, stiffness=5e4, size=1.0):
    """A flap with a rubber ball on its end that meets a plane through its hinge after 1.1 rad; off the origin."""
    turn = rotation((0.2, 1.0, -0.3), 0.6)
    axes, hub = matrix(turn), size * np.array([0.7, -0.4, 1.3])
    meets = axes @ (np.cos(1.1), np.sin(1.1), 0.0)
    normal = -np.cross(axes[:, 2], meets)
    flap = Body("flap", 3.0, size**2 * np.array([0.03, 0.2, 0.2]), position=hub, com=size * np.array([0.3, 0.02, 0.01]),
                orientation=turn)  # fmt: skip
    pin = Revolute(GROUND, flap, at=hub, axis=axes[:, 2], name="pin")
    ball = shapes.Sphere(size * radius, at=(size * arm, 0, 0))
    stop = Contact(
        GROUND, flap, ball, stiffness=stiffness / size, plane=(hub - size * radius * normal, normal), name="stop"
    )
    return System([flap], [pin], [stop], gravity=(0, 0, 0))


@pytest.mark.parametrize("size", [0.01, 1.0])
def test_an_end_stop_is_refused_behind_its_plane(size):
    """A plane bounds a half-space: more than half a turn after the stop the ball is in it from the other side."""
    system = buffered(size=size)
    for angle in (0.0, 1.0, 1.12, 1.1 - 3.0, 1.1 + 6.2):  # before it, pressed, or come round without touching
        assert accelerations(system, system.assemble(angles={"pin": angle})).t.size == 1
    for angle in (1.1 + 0.5, 1.1 + 2.5, 1.1 - 3.8):
        deep = size * (0.6 * abs(np.sin(angle - 1.1)))
        with pytest.raises(
            ValueError, match=rf"'stop' .Contact.: 'flap' starts {deep:.4g}\d* m deep.*behind a plane is solid"
        ):
            accelerations(system, system.assemble(angles={"pin": angle}))


def test_a_soft_stop_may_be_pressed_deep():
    soft = buffered(stiffness=10.0)
    assert np.abs(accelerations(soft, soft.assemble(angles={"pin": 1.6})).force("stop").force).max() > 0.0
