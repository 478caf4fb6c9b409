"""Shells that are plates or tables: published frequencies, closed forms, and the seat by a table of a beam."""

import numpy as np
import pytest
from click.testing import CliRunner

from engines import closed_forms
from engines.nvh.cabin.checks import held_in
from engines.nvh.cabin.plate import plate_modes, plate_shell
from engines.nvh.cabin.seat import Cabin
from engines.nvh.cabin.table import read_modes, write_modes
from engines.nvh.cli import nvh
from engines.nvh.excitation import presets
from engines.nvh.excitation.loads import Source
from engines.nvh.mounts import mounts
from engines.nvh.planar_model import Flat

RIGID_MODES = 3  # [1] of a plate: heave, roll, pitch
HEADER = "mode,frequency,damping,place,x,y,z"

SQUARE = (13.489, 19.789, 24.432, 35.024, 35.024, 61.526, 61.526)
"""w a^2 sqrt(rho h / D), nu = 0.3: A. W. Leissa, The free vibration of rectangular plates, J. Sound Vib. 31 (1973)."""


def test_products_of_beam_functions_give_the_published_frequencies():
    assert closed_forms.free_plate(1.0, 0.3, 7) == pytest.approx(SQUARE, rel=5e-5)  # five digits printed


@pytest.mark.parametrize(("ratio", "poisson"), [(1.0, 0.3), (2.5, 0.3), (1.7, 0.22)])
def test_frequencies_of_a_free_plate_lie_below_upper_bounds(ratio, poisson):
    """A Ritz with more freedom than 36 beam functions: lower, by less than 1.7 %."""
    found = plate_modes(ratio, 1.0, poisson)[0][RIGID_MODES : RIGID_MODES + 7] * ratio**2
    share = found / closed_forms.free_plate(ratio, poisson, 7)
    assert share.max() < 1.0 + 1e-6 and share.min() > 0.983


@pytest.mark.parametrize("ratio", [1.0, 2.3])
def test_a_plate_that_does_not_narrow_bends_as_a_beam(ratio):
    """Poisson's ratio 0: a cylinder across the plate is a mode, in closed form; and at a corner it moves like it."""
    found, known = plate_modes(ratio, 1.0, 0.0)[0] * ratio**2, closed_forms.bending_roots(2) ** 2
    for value in known:
        # polynomials up to 11 of a wave and a half
        assert np.abs(found - value).min() < 1e-6 * value
    shell = plate_shell(700.0, ratio, 1.0, 20.0, 0.02, poisson=0.0)
    rates = (
        shell.rates[3 + RIGID_MODES :]
        / shell.rates[3 + RIGID_MODES]
        * plate_modes(ratio, 1.0, 0.0)[0][RIGID_MODES]
        * ratio**2
    )
    if ratio > 1.0:
        k = 3 + RIGID_MODES + int(np.abs(rates - known[0]).argmin())
        s = np.linspace(0.0, 1.0, 9)
        line = shell.at(np.stack([ratio * (s - 0.5), 0.3 + 0 * s, 0 * s], axis=1))[k].reshape(-1, 3)
        shape = closed_forms.bending_shape(closed_forms.bending_roots(1)[0], s) / np.sqrt(700.0)
        assert np.abs(line[:, 2] @ shape) == pytest.approx(shape @ shape, rel=1e-6)
        assert np.abs(line[:, 2]) == pytest.approx(np.abs(shape), abs=1e-6)


def test_a_place_above_the_plate_moves_with_its_normal():
    shell, at, h = plate_shell(700.0, 3.0, 1.3, 20.0, 0.02), np.array([0.7, -0.2, 0.0]), 1e-5
    steps = h * np.eye(3)[:2]
    slope = (shell.at(at + steps).reshape(-1, 2, 3) - shell.at(at - steps).reshape(-1, 2, 3))[:, :, 2] / (2 * h)
    above, on = (shell.at([at + [0, 0, z]]).reshape(-1, 3) for z in (0.4, 0.0))
    # central differences of polynomials of degree 11
    assert above[3:, :2] == pytest.approx(-0.4 * slope[3:], abs=1e-8)
    assert above[:, 2] == pytest.approx(on[:, 2]) and np.array_equal(above[:3], on[:3])


def test_a_rigid_plate_is_a_rigid_body():
    """Unit modal mass: the sum over rigid modes is the receptance of a body of that mass and inertia."""
    m, a, b, w = 820.0, 3.4, 1.5, 2.0
    shell, at = plate_shell(m, a, b, 30.0, 0.03), np.array([[0.8, -0.4, 0.2]])
    shapes = shell.at(at)[: 3 + RIGID_MODES]
    x, y, z = at[0]
    arm = np.hstack([np.eye(3), -np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])])
    body = np.diag([1 / m] * 3 + [12 / (m * b**2), 12 / (m * a**2), 12 / (m * (a**2 + b**2))])
    known, numbers = arm @ body @ arm.T, plate_modes(a, b)[0]
    # rigid modes of `eigh`: roundings of the largest eigenvalue turn them into the first elastic ones
    limit = np.finfo(float).eps * (numbers[-1] / numbers[RIGID_MODES]) ** 2 * np.abs(known).max()
    assert shapes.T @ shapes == pytest.approx(known, abs=limit)
    assert w > 0 and (shell.rates[: 3 + RIGID_MODES] == 0).all() and (shell.damping[: 3 + RIGID_MODES] == 0).all()


def test_the_seat_by_a_table_of_the_beam_is_that_of_the_beam(tmp_path):
    held, car = held_in("compact", "inline_3"), mounts.car("compact")
    beam, places = Cabin(car, held), [mount.name for mount in held.placed] + ["seat"]
    shapes = np.hstack([beam.at_feet, beam.at_seat])
    file = write_modes(beam.shell, shapes, places, tmp_path / "modes.csv")
    table = Cabin(car, held, str(file))
    found = held.answer(Source(presets.preset("inline_3"), 0.7), [1400.0, 3100.0])
    # the file has nine digits
    assert table.seat(found) == pytest.approx(beam.seat(found), rel=1e-6, abs=1e-7 * np.abs(beam.seat(found)).max())
    with pytest.raises(ValueError, match="plane: a table of modes knows its places only; give a shell of a beam"):
        Flat(held).seat(table, found.rpm, found.orders, found.load)  # needs the shell in the plane, beside its places


def test_the_plate_is_felt_as_another_shell():
    held, car = held_in("saloon", "v6_90"), mounts.car("saloon")
    found = held.answer(Source(presets.preset("v6_90")), np.linspace(700.0, 6000.0, 30))
    beam, plate = (np.abs(Cabin(car, held, kind).seat(found)).max() for kind in ("beam", "plate"))
    assert 0.1 < plate / beam < 10.0 and abs(plate / beam - 1) > 0.01


LINES = [
    "1,0,0,left,0.1,0,0", "1,0,0,seat,0.1,0,0",
    "2,31.5,0.03,left,0.01,0,0.02", "2,31.5,0.03,seat,0.0,0,-0.01",
]  # fmt: skip


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (lambda x: [*x[:2], "2,31.5,-0.03,left,0,0,0"], "line 4: damping: -0.03"),
        (lambda x: [*x[:2], "2,-31.5,0.03,left,0,0,0"], "line 4: frequency: -31.5"),
        (lambda x: [*x[:2], "2,,0.03,left,0,0,0"], "line 4: frequency is ''; give a number"),
        (lambda x: [*x[:3], "2,32,0.03,seat,0,0,0"], "mode '2' is given twice at 'seat' or with another frequency"),
        (lambda x: [*x, x[-1]], "line 6: mode '2' is given twice at 'seat'"),
        (lambda x: x[:3], "mode '2' and the first differ in seat"),
        (lambda x: ["1,2,3"], "line 2 has 3 values; give 7"),
        (lambda x: [], "no modes; give a line"),
    ],
)
def test_tables_that_are_no_shell_are_refused(tmp_path, change, text):
    (tmp_path / "m.csv").write_text("\n".join([HEADER, *change(LINES)]), encoding="utf-8")
    with pytest.raises(ValueError, match="shell 'm.csv'") as found:
        read_modes(tmp_path / "m.csv")
    assert text in str(found.value)


def test_other_shells_are_refused(tmp_path):
    (tmp_path / "m.csv").write_text("\n".join([HEADER, *LINES]), encoding="utf-8")
    (tmp_path / "head.csv").write_text("a,b\n", encoding="utf-8")
    held, car = held_in("bench", "single"), mounts.car("bench")
    for made_of, text in (
        ("tub", "shell 'tub' is unknown; give beam, plate or a file"),
        ("plate", "its shell is not known; give compact or saloon, or a file of modes"),
        (str(tmp_path / "m.csv"), "no place 'front left'; it has left, seat"),
        (str(tmp_path / "head.csv"), "line 1 must be 'mode,frequency,damping,place,x,y,z'"),
        (str(tmp_path / "none.csv"), "No such file"),
    ):
        with pytest.raises(ValueError, match=text):
            assert Cabin(car, held, made_of).at_feet.size == 0
    with pytest.raises(ValueError, match="a place lies beyond"):
        plate_shell(700.0, 3.0, 1.3, 20.0, 0.02).at([[0.0, 0.9, 0.0]])
    for wrong in (dict(mass=0.0), dict(first=-1.0), dict(width=0.0), dict(damping=-0.1), dict(poisson=0.7)):
        with pytest.raises(ValueError, match=f"{next(iter(wrong))}|mode"):
            plate_shell(**dict(mass=700.0, length=3.0, width=1.3, first=20.0, damping=0.02) | wrong)


@pytest.mark.slow
def test_the_command_takes_a_shell():
    found = CliRunner().invoke(nvh, ["inline_3", "--shell", "plate"])
    assert found.exit_code == 0, found.output
    assert "modes of the shell, plate" in found.output
