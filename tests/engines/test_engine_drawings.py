"""Drawings and words of the engines' pages: they show what the numbers say."""

import re
from dataclasses import replace

import numpy as np
import pytest

from engines.balance import spatial
from engines.balance.layouts import Engine, layout, names
from engines.balance.pages import drawings, portrait
from engines.balance.pages.sheets import Harmonic

RNG = np.random.default_rng(7)


@pytest.mark.parametrize(
    ("forward", "backward", "motion", "cure"),
    [
        (2 - 1j, 0, "turns with the crank, constant size", "counterweights on the crank"),
        (0, 1j, "turns against the crank, constant size", "a shaft at 1x against the crank"),
        (
            1 + 1j,
            1 - 1j,
            "swings at 45\u00b0 from x",
            "counterweights on the crank and a shaft at 1x against the crank",
        ),
        (1j, 1j, "swings along x", "counterweights on the crank and a shaft at 1x against the crank"),
        (1j, -1j, "swings along y", "counterweights on the crank and a shaft at 1x against the crank"),
        (1, 3j, "ellipse, against the crank", "counterweights on the crank and a shaft at 1x against the crank"),
        (1e-12, 1e-13, "balanced", ""),
    ],
)
def test_harmonics_in_words(forward, backward, motion, cure):
    h = Harmonic(1, "couple", complex(forward), complex(backward), noise=1e-9)
    assert (h.motion, h.cure) == (motion, cure)


def test_the_ellipse_is_the_path_of_the_sum():
    """Points of the turning sum, seen along the drawn half axes, fulfil (x/a)^2 + (y/b)^2 = 1."""
    for forward, backward in RNG.normal(size=(20, 4)).view(complex):
        found = re.search(
            r'rx="([\d.]+)" ry="([\d.]+)" transform="rotate\((.*?)\)"', drawings.ellipse(forward, backward, 88)
        )
        long, short, turn = map(float, found.groups())
        q = np.linspace(0, 2 * np.pi, 37)
        z = forward * np.exp(3j * q) + np.conj(backward) * np.exp(-3j * q)
        z *= (
            88 / (abs(forward) + abs(backward)) * np.exp(1j * np.radians(turn))
        )  # y of the page is down, so is its turn
        # numbers on the page have two decimals: 0.005 of half axes of 2 and more
        assert np.abs((z.real / long) ** 2 + (z.imag / short) ** 2 - 1).max() < 0.02 or short < 2


def test_bars_are_as_high_as_the_amplitudes():
    values = {way: RNG.uniform(0.1, 3.0, 6) for way in ("phasor", "planar", "spatial")}
    found = re.findall(
        r'fill t(\d)" x="[\d.]+" y="([\d.]+)" width="12.5" height="([\d.]+)"', drawings.bars(values, 6 * [""], "")
    )
    heights = np.array([float(height) for *_, height in found]).reshape(6, 3).T
    wanted = np.array(list(values.values()))
    assert np.abs(heights / 108 - wanted / wanted.max()).max() < 1e-4  # two decimals of 108
    assert [float(y) + float(h) for _, y, h in found] == pytest.approx(18 * [132.0], abs=0.011)


@pytest.mark.parametrize("name", names())
def test_sketches_hold_every_part_within_their_frame(name):
    text = portrait.sketch(Engine(name))
    cylinders = len(layout(name).pins)
    assert [text.count(f'class="{kind}') for kind in ("rod", "fill piston")] == [cylinders, cylinders]
    assert text.count('class="fill crown') + text.count('class="fill skirt') == cylinders
    left, top, width, height = map(float, re.search(r'viewBox="(.*?)"', text)[1].split())
    points = np.array([p.split() for d in re.findall(r' d="M(.*?)Z?"', text) for p in d.split("L")], float)
    assert points.min(axis=0) == pytest.approx(
        [left + portrait.DRAWING_MARGIN, top + portrait.DRAWING_MARGIN], abs=0.02
    )
    assert points.max(axis=0) == pytest.approx(
        [left + width - portrait.DRAWING_MARGIN, top + height - portrait.DRAWING_MARGIN], abs=0.02
    )


@pytest.mark.parametrize("low,high", [(-17.98, 17.98), (-0.003, 0.0451), (0.0, 1.0), (-2e5, 0.0)])
def test_ticks_are_round_and_within(low, high):
    found = drawings.ticks(low, high)
    assert 2 <= found.size <= 6 and low <= found[0] and found[-1] <= high + 1e-12
    assert {f"{step:e}"[0] for step in np.diff(found)} <= set("125")


@pytest.mark.parametrize("name", ["I5", "V8_cross", "boxer4"])
def test_an_upright_engine_is_the_engine_turned(name):
    """The reaction of the mount turns with the world; the crank lies along x and the middle of the bores is up."""
    engine = replace(Engine(name), rpm=130.0)
    R = portrait.upright(engine.layout)
    assert np.abs(R @ R.T - np.eye(3)).max() < 1e-15 and np.linalg.det(R) == pytest.approx(1.0)
    assert np.abs(R @ (0, 0, 1) - (1, 0, 0)).max() < 1e-15
    beta = np.radians(engine.layout.bores)
    bores = R @ np.array([np.cos(beta), np.sin(beta), 0 * beta])
    assert bores[2].min() > -1e-15 and abs(bores[1].sum()) < 1e-12
    flat = spatial.build(engine, gravity=(1.0, -3.0, 2.0))
    here, there = spatial.turn(flat, engine), spatial.turn(portrait.turned(flat, R), engine)
    for part in ("force", "moment"):
        a, b = getattr(here.reaction("mount"), part), getattr(there.reaction("mount"), part)
        assert np.abs(b - a @ R.T).max() < 1e-12 * np.abs(a).max()
