"""What a console and a notebook show of results: a screen at most, in letters of one width."""

import html
import re

import numpy as np
import pytest

from mbsd3d import (
    GROUND,
    Body,
    Bushing,
    Input,
    Revolute,
    Stepper,
    Study,
    System,
    Torque,
    bearing_load,
    campbell,
    explain,
    fit,
    linearize,
    measures,
    read_mjcf,
    samples,
    simulate,
    spectrum,
    state_space,
    uncertainty,
    verify,
)  # fmt: skip

LINES, LINE, CHARACTERS = 24, 320, 2500  # of a screen; a line may wrap


def pendulum(length=0.7, mass=1.3):
    bob = Body("bob", mass, (0.05, 0.06, 0.07), position=(0.1, 0.2, -length))
    return System([bob], [Revolute(GROUND, bob, at=(0, 0, 0), axis=(0.1, 1, 0.2), name="hinge")])


def end(solution):
    return {"end": solution.angle("hinge")[-1]}


@pytest.fixture(scope="module")
def run():
    return simulate(pendulum(), 1.0, output=101)


def shown(results):
    """Check each; the text that a notebook shows stands in a preformatted block, a table, a picture or a frame."""
    for name, result in results.items():
        text = repr(result)
        lines = text.splitlines()
        assert len(lines) <= LINES and len(text) <= CHARACTERS, (name, len(lines), len(text))
        assert max(map(len, lines)) <= LINE and " object at 0x" not in text, (name, text)
        page = result._repr_html_()
        assert re.match(r"<(pre|table|iframe|div|img)\b", page.lstrip()), (name, page[:80])


def test_results_of_a_run(run, tmp_path):
    shown({
        "solution": run, "state": run.final, "certificate": run.certificate, "system": run.system,
        "check": run.system.check(), "reaction": run.reaction("hinge"), "energy": run.energy(),
        "momentum": run.momentum(), "drift": run.drift(), "estimate": run.estimate(),
        "bearing": bearing_load(run, run.system.joints[0]), "spectrum": run.spectrum("angle", "hinge", window="hann"),
        "density": run.density("angle", "hinge"), "verified": verify(run.bundle(tmp_path / "run.zip")),
        "of samples": spectrum(run.t, np.cos(run.t), window="hann"),
    })  # fmt: skip
    exported = run.system.to_mjcf(tmp_path / "pendulum.xml")
    shown({"exported": exported, "imported": read_mjcf(tmp_path / "pendulum.xml")})
    assert "Stepper" in repr(Stepper(run.system)) or "stepper" in repr(Stepper(run.system))


def test_a_certificate_shows_in_a_console_what_it_prints(run):
    assert repr(run.certificate).splitlines()[:3] == str(run.certificate).splitlines()[:3]
    assert html.escape(str(run.certificate)) in run.certificate._repr_html_()


def test_results_of_small_motions():
    bob = pendulum().bodies[0]
    hinge = Revolute(GROUND, bob, at=(0, 0, 0), axis=(0.1, 1, 0.2), name="hinge")
    driven = System([bob], [hinge], [Torque(bob, torque=(0, Input("u", 0.0), 0), name="motor")])
    rest = driven.equilibrium()
    linear = linearize(driven, rest.state)
    model = state_space(driven, rest.state, inputs=["u"], outputs=[measures.angle(hinge)])
    shown({
        "equilibrium": rest, "linear": linear, "mode": linear.modes[0], "model": model,
        "response": model.frequency_response(np.linspace(0.3, 9.0, 50)),
    })  # fmt: skip
    hub, rotor = Body("hub", 1.1, (0.05, 0.06, 0.07)), Body("rotor", 3.0, (0.2, 0.11, 0.11))
    spin = Revolute(hub, rotor, at=(0, 0, 0), axis=(1, 0, 0), name="spin")
    mount = Bushing(GROUND, hub, at=(0, 0, 0), stiffness=(1e4, 1.1e4, 2e4), turning_stiffness=(1e3, 1.2e3, 2e3))
    shown(
        {
            "whirl": campbell(
                System([hub, rotor], [spin], [mount], gravity=(0, 0, 0)), spin=spin, speeds=np.linspace(0.0, 90.0, 4)
            )
        }
    )


def test_results_of_studies():
    study = Study(pendulum, {"length": 0.7, "mass": 1.3}, end, {"t_end": 0.3, "output": 11})
    angles = Study(pendulum, {"length": 0.7}, lambda solution: solution.angle("hinge"), {"t_end": 0.3, "output": 11})
    shown({
        "study": study, "gradient": study.gradient(), "fit": fit(angles, 1.01 * angles.fun(), sigma=0.1),
        "uncertainty": uncertainty(study, {"length": ("normal", 0.7, 0.01), "mass": ("uniform", 1.2, 1.4)}, 8),
        "samples": samples({"length": (0.5, 0.9), "mass": (1.0, 2.0)}, 16),
        "explained": explain(pendulum, end, run={"t_end": 0.3, "output": 11}),
    })  # fmt: skip
