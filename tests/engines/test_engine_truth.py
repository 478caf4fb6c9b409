"""Published figures of the toy engines against what is computed here: every entry of the data file."""

import numpy as np
import pytest
from click.testing import CliRunner
from helpers.closed_forms.slider_crank import SliderCrank, slider_crank_loads

from engines.balance import cli, report
from engines.balance.layouts import data
from engines.balance.published import corrections, truth

KNOWN = {
    "all (flat-vs-boxer article table)": {
        "1x along the bore, one cylinder": (9.87, 10.966), "1x pitch couple, flat 4": (3.948, 4.386),
        "1x pitch couple, I3": (1.709, 1.899), "1x couple across, flat 4": (0, 1.316),
        "1x couple across, I3": (0, 0.570),
    },
    "I4 sanity check in flat-vs-boxer article": {
        "F_single = F_2x / (4 R / L)": (8.22, 9.87), "2x of one cylinder": (None, 4.111),
        "2x to leading order": (15.35, 16.444), "2x over leading order": (None, 1.071),
    },
    "R/L sweep": {
        "2x over leading order, R/L = 0.25": (None, 1.016), "2x over leading order, R/L = 0.3333": (None, 1.029),
        "2x over leading order, R/L = 0.5": (None, 1.071), "2x over leading order, R/L = 0.6667": (None, 1.143),
    },
    "Boxer-4": {
        "1x couple": (0, 0), "2x yaw couple, staggered by 0.1 m": (0, 0.822), "2x driving torque": (None, 17.43),
        "2x driving torque, inline four": (None, 17.43),
    },
    "Non-boxer flat-4": {
        "1x couple": (3.948, 4.386), "2x couple": (0, 0.822), "over inline three, per bore spacing": (2.31, None),
        "over inline three, per distance of pairs": (1.15, None),
    },
    "I3": {
        "1x couple over F1 a": (1.732, None), "2x couple over F2 a": (1.732, None), "6x force": (0.0715, 0.0715),
        "3x driving torque": (None, 9.58),
    },
    "I5": {
        "peak of the primary moment": (66.56, None), "of which 1x": (10.64, None), "of which 2x": (58.98, None),
        "1x couple over F1 a, I5": (0.449, None), "2x couple over F2 a, I5": (4.980, None),
        "1x couple over F1 a, I5_sequential": (4.253, None), "2x couple over F2 a, I5_sequential": (2.629, None),
    },
    "I6 / V12": {
        "forces and couples 1x ... 5x, I6": (None, 0), "forces and couples 1x ... 5x, V12": (None, 0),
        "6x force, I6": (None, 0.143), "6x force, V12": (None, 0.248), "3x driving torque, I6": (None, 19.16),
        "6x driving torque, V12": (None, 0.616),
    },
    "V6 60": {
        "6x force": (None, 0.124),
        "1x couple over F1 a, V6_60_offset+60, forward": (1.5, None),
        "1x couple over F1 a, V6_60_offset+60, backward": (0, None),
        "2x couple over F2 a, V6_60_offset+60, forward": (0, None),
        "2x couple over F2 a, V6_60_offset+60, backward": (1.5, None),
        "1x couple over F1 a, V6_60_offset-60, long half axis": (3, None),
        "1x couple over F1 a, V6_60_offset-60, short half axis": (0, None),
        "1x couple over F1 a, V6_60_shared, long half axis": (2.598, None),
        "1x couple over F1 a, V6_60_shared, short half axis": (0.866, None),
    },
    "V6 90 (3D article prose)": {
        "2x couple over F2 a, V6_90_shared, long half axis": (2.449, None),
        "2x couple over F2 a, V6_90_shared, short half axis": (0, None),
        "1x couple over F1 a, V6_90_shared, forward": (1.732, None),
        "1x couple over F1 a, V6_90_shared, backward": (0, None),
        "1x couple over F1 a, V6_90_split30, long half axis": (2.121, None),
        "1x couple over F1 a, V6_90_split30, short half axis": (1.225, None),
        "2x couple over F2 a, V6_90_split30, long half axis": (2.121, None),
        "2x couple over F2 a, V6_90_split30, short half axis": (1.225, None),
    },
    "V8 flat-plane": {
        "2x horizontal force": (23.256, 23.256), "2x vertical force": (None, 0), "4x vertical force": (1.669, 1.669),
        "couples 1x, 2x": (None, 0),
    },
    "V8 cross-plane": {
        "1x couple over F1 a, V8_cross, forward": (3.162, None),
        "1x couple over F1 a, V8_cross, backward": (0, None),
        "1x couple, real crank": (3.121, 4.508), "2x couple, real crank": (0, 0), "1x couple, preset": (2.79, 4.032),
        "2x pitch couple, preset": (1.163, 1.163), "least moment of the gif": (34, None),
        "largest moment of the gif": (100.282, None), "4x force": (None, 1.669),
    },
    "V10 72": {
        "1x couple over F1 a, V10_72_steps_of_144, long half axis": (3.441, None),
        "1x couple over F1 a, V10_72_steps_of_144, short half axis": (1.816, None),
        "2x couple over F2 a, V10_72_steps_of_144, long half axis": (4.755, None),
        "2x couple over F2 a, V10_72_steps_of_144, short half axis": (2.127, None),
        "1x couple over F1 a, V10_72, long half axis": (0.588, None),
        "1x couple over F1 a, V10_72, short half axis": (0.310, None),
        "2x couple over F2 a, V10_72, long half axis": (5.568, None),
        "2x couple over F2 a, V10_72, short half axis": (2.490, None),
    },
    "V engines, rotating mass": {
        "1x couple, crank's centre on the axis": (3.412, 4.032),
        "1x couple, masses with U = 0, m_rec = 9 kg": (2.79, 2.79),
    },
    '"odd harmonics >= 3 are exactly zero"': {
        "3x force, centred": (None, 0), "3x force, bore offset by 0.1 m": (None, 0.1416),
        "3x driving torque per cylinder": (None, 3.19),
    },
}  # fmt: skip
"""(assumed, actual) as the data file states them in words, and 4.508, 9.58, 0.1416, 0.616 as found here."""


def same_digits(found: float | None, stated: float | None) -> bool:
    """Equal to half a unit of the last digit stated; None for None."""
    if found is None or stated is None:
        return found is stated
    digits = len(f"{stated:.10g}".partition(".")[2])
    return abs(found - stated) <= 0.501 * 10.0**-digits if stated else abs(found) < 1e-9


@pytest.mark.parametrize("source", [entry["layout"] for entry in data()["published_vs_true_physics"]])
def test_every_correction_of_the_data_file(source):
    rows = {row.what: row for row in corrections.corrections() if row.source == source}
    assert set(rows) == set(KNOWN[source])
    for what, (assumed, actual) in KNOWN[source].items():
        assert same_digits(rows[what].assumed, assumed), (what, rows[what].assumed, assumed)
        assert same_digits(rows[what].actual, actual), (what, rows[what].actual, actual)
        assert rows[what].verdict


def test_every_published_check():
    checks, rows = data()["published_checks"], truth.published_checks()
    for check, row in zip(checks, rows, strict=True):
        if check["published"] is None:
            np.testing.assert_allclose(row.actual, check["computed"], rtol=0, atol=6e-3)  # two digits
            continue
        # the data file was computed at every degree, to four to nine digits
        assert row.assumed == pytest.approx(check["computed"], rel=2e-4, abs=1e-9), check["what"]
        assert row.assumed == pytest.approx(row.published, rel=6e-3, abs=1e-9), check["what"]
        assert ("agrees" in row.verdict) == (abs(row.actual - row.published) <= 6e-3 * abs(row.published) + 1e-9)


def test_every_gif():
    rows = truth.gifs()
    assert len(rows) == len(data()["toy_set_2"]["checks"])
    for row in rows:
        assert row.assumed == pytest.approx(row.published, abs=6e-4)  # three digits
    assert next(row for row in rows if "V8_flat" in row.what).actual == pytest.approx(
        111.662, abs=5e-4
    )  # to the digits in the file


def test_single_cylinder_under_its_weight():
    for row in truth.at_top():
        assert same_digits(round(row.assumed, 2), row.published), row
    peaks = [float(np.abs(truth.single(weight).torque).max()) for weight in (False, True)]
    assert peaks == pytest.approx([6.8925, 33.1231], abs=1e-4)  # found in steps of 0.1 degree


@pytest.mark.parametrize("weight", [False, True])
@pytest.mark.parametrize("centripetal", [False, True])
def test_bearing_of_the_single_cylinder_against_newton_and_euler(weight, centripetal):
    mechanism = SliderCrank(1.0, 2.0, 2.0, 0.5, 4.0, 0.5, 1 / 3, 5.0)
    angle, gravity = np.radians(np.arange(3601) / 10), (0.0, -9.81 * weight)
    loads = slider_crank_loads(mechanism, angle, np.pi / 3, gravity=gravity, centripetal=centripetal)
    bearing = truth.single(weight, centripetal).bearing
    np.testing.assert_allclose(bearing, np.hypot(*loads.bearing.T), rtol=1e-11)  # rounding of the spatial model


def test_truth_on_the_command_line():
    first, second = (CliRunner().invoke(cli.main, ["--truth"]) for _ in range(2))
    assert first.exit_code == 0 and first.output == second.output
    assert str(report.truth(truth.rows())) in first.output
    for entry in data()["published_checks"]:
        assert entry["what"].strip() in first.output


def test_truth_about_one_layout_on_the_command_line():
    found = CliRunner().invoke(cli.main, ["--truth", "V8_flat"]).output
    assert "peak force V8_flat" in found and "2x horizontal force" in found and "I4" not in found
    assert "with weight, all terms" in CliRunner().invoke(cli.main, ["--truth", "single"]).output
    assert (
        CliRunner().invoke(cli.main, ["--truth", "V6_120_shared"]).output
        == "no published figure is about V6_120_shared\n"
    )
