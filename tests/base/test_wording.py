"""Numbers, units and names as people read them."""

import math

import pytest
from helpers.printed_numbers import number

from mbsd3d.base.wording import counted, digits, error_text, readable, relative, triple, typeset, with_article


def test_numbers_are_written_as_people_write_them():
    values = (0.0, 1.0, -2.5, 1234.5678, 1e-5, -1e-5, 2.345678e-7, 3.2e12, 18140.4, -123456.7, 999999.9)
    assert [digits(x) for x in values] == [
        "0", "1", "−2.5", "1235", "10⁻⁵", "−10⁻⁵", "2.346 · 10⁻⁷", "3.2 · 10¹²", "18\u202f140", "−123\u202f500", "10⁶",
    ]  # fmt: skip
    assert digits(3e-14, size=1e3) == "0" and digits(math.nan, size=1.0) == "nan" and digits(math.inf) == "inf"
    assert triple((1.0, 2e-17, -3.0)) == "(1, 0, −3)"
    assert relative(0.0) == error_text(0.0) == "0" and error_text(5.55e-16, 3) == "5.55e-16"


@pytest.mark.parametrize("x", [math.pi * 10.0**k * (-1.0) ** k for k in range(-12, 13)])
def test_a_printed_number_reads_back(x):
    assert number(digits(x)) == pytest.approx(x, rel=5e-4, abs=0.0)  # four digits
    assert number(digits(x, count=6)) == pytest.approx(x, rel=5e-6, abs=0.0)
    assert number(relative(x, count=2)) == pytest.approx(x, rel=5e-2, abs=0.0)
    assert number(typeset(f"{x:.3f}")) == pytest.approx(x, rel=0.0, abs=5.1e-4)


def test_texts_of_terminals_become_those_of_pages():
    pairs = {
        "5.6e-16": "5.6 · 10⁻¹⁶", "-12345.678": "−12\u202f345.678",
        "limit 1e-06; up to -3 mm/s2": "limit 10⁻⁶; up to −3 mm/s²",
        "1999 cm3, 18 140 N m, kg m^2": "1999 cm³, 18\u202f140 N m, kg m²", "(-1, -2.5)": "(−1, −2.5)",
        "86 x 86 mm": "86 × 86 mm",
    }  # fmt: skip
    assert {text: readable(text) for text in pairs} == pairs


@pytest.mark.parametrize(
    "name", ["inline-4", "arm-2 e-1", "x-1e5y", "v1e3", "2026-11-25", "800-6000", "m2", "hinge_1e2"]
)
def test_names_stay(name):
    assert readable(name) == name


def test_nouns_and_articles():
    names = ("Revolute", "AngleDriver", "FMU", "URDF", "Universal", "Unbalance", "RSSR", "SDF file", "hinge", "input")
    assert [with_article(x).split()[0] for x in names] == ["a", "an", "an", "a", "a", "an", "an", "an", "a", "an"]
    assert [counted(1, "body"), counted(3, "body"), counted(0, "joint")] == ["1 body", "3 bodies", "0 joints"]
    assert [counted(2, x) for x in ("axis", "box", "array", "mesh file")] == [
        "2 axes",
        "2 boxes",
        "2 arrays",
        "2 mesh files",
    ]
