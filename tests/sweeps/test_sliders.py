"""Sliders of a notebook: the picture follows them, and what cannot be is said."""

import builtins

import pytest

from mbsd3d import linkages, sliders


def wiper(crank=0.05, rocker=0.09):
    """A spatial four-bar whose rod is 0.35 m long."""
    return linkages.rssr(crank=crank, rod=0.35, rocker=rocker, distance=0.32, twist=1.3, angle=0.4)


RANGES = {"crank": (0.02, 0.9), "rocker": (0.10, 0.12)}


@pytest.fixture
def shown():
    pytest.importorskip("ipywidgets", reason="the extra `notebook` is not installed")
    return sliders(wiper, RANGES, look=lambda system: repr(system))


def test_sliders_start_at_the_defaults_or_in_the_middle(shown):
    crank, rocker, place = shown.children
    assert (crank.value, rocker.value) == (0.05, pytest.approx(0.11, rel=1e-12))
    assert place.children[0].value.startswith("<system")


def test_a_mechanism_that_cannot_be_says_why_and_comes_back(shown):
    crank, _, place = shown.children
    first = place.children[0].value
    crank.value = 0.9
    assert "rod" in place.children[0].value
    crank.value = 0.05
    assert place.children[0].value == first


def test_the_picture_follows():
    pytest.importorskip("ipywidgets", reason="the extra `notebook` is not installed")
    crank, _, place = sliders(wiper, RANGES).children
    first = bytes(place.children[0].value)
    crank.value = 0.03
    second = bytes(place.children[0].value)
    assert first.startswith(b"\x89PNG") and second.startswith(b"\x89PNG") and first != second


@pytest.mark.parametrize(
    "ranges, said",
    [
        ({"crank": (0.08, 0.02)}, "give the lower end first"),
        ({"crank": 0.05}, "give two numbers"),
        ({"rod": (0.3, 0.4)}, "build does not take the parameters rod"),
    ],
)
def test_wrong_ranges_are_refused(ranges, said):
    pytest.importorskip("ipywidgets", reason="the extra `notebook` is not installed")
    with pytest.raises(ValueError, match=said):
        sliders(wiper, ranges)


def test_without_ipywidgets_it_says_what_to_install(monkeypatch):
    known = builtins.__import__

    def absent(name, *rest):
        if name == "ipywidgets":
            raise ImportError(name)
        return known(name, *rest)

    monkeypatch.setattr(builtins, "__import__", absent)
    with pytest.raises(ValueError, match=r"mbsd3d\[notebook\]"):
        sliders(wiper, RANGES)
