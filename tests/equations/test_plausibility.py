"""What is legal and hardly meant is named by `check` and by the run, and nothing else is."""

import numpy as np
import pytest

from mbsd3d import GROUND, Body, Force, Revolute, Spherical, System, Tyre, simulate


def pendulum(inertia, mass=2.0, arm=0.4):
    body = Body("arm", mass, inertia * np.array([0.01, 0.03, 0.035]), position=(0.3, -0.2, 1.0), com=(arm, 0.05, -0.02))
    return body, Revolute(GROUND, body, at=(0.3, -0.2, 1.0), axis=(0.1, 1.0, 0.2), name="hinge")


def inertia_notes(system):
    return [note for note in system.check().notes if "radius of gyration" in note]


def test_inertias_in_kg_mm2_are_named():
    """A million times too much: the radius of gyration a thousand times, 0.13 m instead of 132 m."""
    body, hinge = pendulum(1e6)
    (note,) = inertia_notes(System([body], [hinge]))
    radius = np.sqrt(1e6 * 0.035 / 2.0)
    assert note.startswith(f"body 'arm': its radius of gyration is {radius:.3g} m") and "kg m^2" in note
    assert note in str(System([body], [hinge]).check())
    assert not inertia_notes(System(*([x] for x in pendulum(1.0))))


def test_rotors_and_parts_whose_mass_is_elsewhere_are_not():
    """A rotor balanced to a tenth of a millimetre on one bearing; a flywheel of 1e-9 kg on a heavy frame."""
    rotor, bearing = pendulum(1.0, arm=1e-4)
    rotor = Body("rotor", 2.0, (0.01, 0.03, 0.035), position=(0.3, -0.2, 1.0), com=(1e-4, 0, 0))
    assert not inertia_notes(System([rotor], [Revolute(GROUND, rotor, at=rotor.position, axis=bearing.axis)]))
    frame, hinge = pendulum(1.0, mass=20.0)
    wheel = Body("wheel", 1e-9, (0.01, 0.01, 0.02), position=(0.5, -0.2, 1.0))
    assert not inertia_notes(System([frame, wheel], [hinge, Revolute(frame, wheel, at=wheel.position, axis=(0, 0, 1))]))


def stone(name, z):
    return Body(name, 1.5, (0.01, 0.02, 0.025), position=(0.2, 0.1, z), com=(0.01, 0, 0.02), omega=(1.0, 2.0, 0.5))


def test_a_body_that_nothing_acts_on_is_named_by_check_and_run():
    body, hinge = pendulum(1.0)
    system = System([body, stone("forgotten", 3.0)], [hinge])
    run = simulate(system, 0.1)
    for notes in (system.check().notes, run.certificate.notes):
        assert "body 'forgotten' has no joint and no force: nothing but gravity acts on it" in notes
        assert not any("body 'arm'" in note for note in notes)
    assert run.certificate.passed


@pytest.mark.parametrize(
    "hold",
    [
        lambda a, b: dict(joints=[Spherical(a, b, at=(0.2, 0.1, 2.0))]),
        lambda a, b: dict(forces=[Force(a, (0, 0, 1.0)), Force(b, (0, 0, 1.0))]),
        lambda a, b: dict(forces=[Tyre(a, b, axis=(0, 1, 0), radius=0.3, stiffness=1e4, plane=((0, 0, 0), (0, 0, 1)))]),
        lambda a, b: {},  # two stones, and nothing else: it is meant
    ],
)
def test_others_are_not(hold):
    one, two = stone("one", 1.0), stone("two", 3.0)
    assert not any("nothing but gravity" in note for note in System([one, two], **hold(one, two)).check().notes)
