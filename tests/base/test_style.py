"""The house style: every line is seen on its paper and told from the others with any colour vision; nothing leaks."""

import itertools
import re
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from matplotlib import style

import mbsd3d
from mbsd3d import Body, System, save_figure, simulate
from mbsd3d.base import style as own
from mbsd3d.extend import Theme, figure_style, theme

LIGHT, DARK = theme(False), theme(True)
# Machado, Oliveira and Fernandes 2009, severity 1, for linear RGB
VISION = {
    "normal": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "protanopia": ((0.152286, 1.052583, -0.204868), (0.114503, 0.786281, 0.099216), (-0.003882, -0.048116, 1.051998)),
    "deuteranopia": ((0.367322, 0.860646, -0.227968), (0.280085, 0.672501, 0.047413), (-0.011820, 0.042940, 0.968881)),
    "tritanopia": ((1.255528, -0.076749, -0.178779), (-0.078411, 0.930809, 0.147602), (0.004733, 0.691367, 0.303900)),
}
TO_XYZ = np.array([(0.4124, 0.3576, 0.1805), (0.2126, 0.7152, 0.0722), (0.0193, 0.1192, 0.9505)])
SETTINGS = {"text.color": "red", "lines.linewidth": 9, "font.family": "serif", "axes.grid": True, "savefig.dpi": 20}


def linear(tint: str) -> np.ndarray:
    """Linear RGB of "#rrggbb" (sRGB)."""
    c = np.array([int(tint[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def contrast(one: str, other: str) -> float:
    """Contrast ratio of WCAG 2."""
    low, high = sorted(TO_XYZ[1] @ linear(tint) for tint in (one, other))
    return (high + 0.05) / (low + 0.05)


def lab(rgb: np.ndarray) -> np.ndarray:
    """CIELAB of linear RGB, D65."""
    xyz = TO_XYZ @ np.clip(rgb, 0, 1) / TO_XYZ.sum(axis=1)
    f = np.where(xyz > 216 / 24389, np.cbrt(xyz), xyz * 841 / 108 + 4 / 29)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def test_formulas_against_known_values():
    assert contrast("#ffffff", "#000000") == pytest.approx(21.0)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.48, abs=0.005)  # just misses the 4.5 of WCAG's text
    assert lab(linear("#ff0000")) == pytest.approx([53.24, 80.09, 67.20], abs=0.05)


@pytest.mark.parametrize("look", [LIGHT, DARK], ids=["light", "dark"])
def test_text_is_legible(look):
    for tint in (look.ink, look.muted):
        assert contrast(tint, look.paper) >= 4.5  # WCAG AA for text
    for tint in (look.good, look.bad):
        assert contrast(look.ink, tint) >= 4.5
    assert 1.2 < contrast(look.grid, look.paper) < 2.0  # seen, but behind everything


def test_lines_stand_out_from_their_paper():
    assert min(contrast(tint, DARK.paper) for tint in DARK.lines) >= 3.0  # WCAG AA for graphics
    # Okabe and Ito's orange and sky blue are as light as they are known to be; they come fourth and fifth
    assert min(contrast(tint, LIGHT.paper) for tint in LIGHT.lines) >= 2.2
    assert min(contrast(tint, LIGHT.paper) for tint in LIGHT.lines[:3]) >= 3.0


@pytest.mark.parametrize("vision", VISION)
@pytest.mark.parametrize("look", [LIGHT, DARK], ids=["light", "dark"])
def test_lines_are_told_apart(look, vision):
    seen = [lab(np.array(VISION[vision]) @ linear(tint)) for tint in look.lines]
    # a difference of 2.3 is just noticeable side by side; thin lines need several times that
    assert min(np.linalg.norm(a - b) for a, b in itertools.combinations(seen, 2)) > 14.0


def test_names():
    assert isinstance(LIGHT, Theme) and LIGHT != DARK and LIGHT.paper != DARK.paper
    assert own.colour(7) == LIGHT.lines[1] and DARK.colour(6) == DARK.lines[0]


def test_colours_of_figures_stand_in_one_place():
    """Lines, papers and texts take their colours from the theme; the paint of bodies is the user's and the demos'."""
    folder = Path(mbsd3d.__file__).parent
    literal = re.compile(r"color\w*[\"']?\s*[=:]\s*[\"'](?!none|auto)")
    files = list(folder.rglob("*.py"))
    assert len(files) > 100 and not [path.name for path in files if literal.search(path.read_text())]
    hexes = re.compile(r"[\"']#[0-9a-fA-F]{6}[\"']")
    mixing = [path.name for path in files if hexes.search(path.read_text())]
    assert mixing == ["style.py"]


def test_settings_of_the_user_change_nothing_and_are_kept(tmp_path):
    stone = Body("stone", 1.0, (0.1, 0.2, 0.3), velocity=(1, 2, 3.0), omega=(0.3, 1, 2))
    run = simulate(System([stone]), 0.5, output=9)
    plain = [path.read_bytes() for path in save_figure(run.plot("omega"), tmp_path / "plain")]
    with style.context(["dark_background", SETTINGS]):
        before = dict(matplotlib.rcParams)
        other = [path.read_bytes() for path in save_figure(run.plot("omega"), tmp_path / "other")]
        assert dict(matplotlib.rcParams) == before
    assert plain == other


def test_the_house_is_left_after_an_error():
    before = dict(matplotlib.rcParams)
    with pytest.raises(ValueError, match="unknown"), figure_style(DARK):
        assert matplotlib.rcParams["figure.facecolor"] == DARK.paper
        raise ValueError("unknown")
    assert dict(matplotlib.rcParams) == before
