"""Formulas in MathML: nothing typed is lost, and what stands above, below and beside is where it belongs."""

import re
import xml.etree.ElementTree as ET

import pytest

from mbsd3d.extend import discover
from mbsd3d.report.mathml import DOTS, GREEK, mathml

DEMOS = discover()


def trees(text):
    return ET.fromstring(f"<div>{mathml(text)}</div>")


def drawn(tree):
    """A tree as text: children in order, what has a place of its own by its kind."""
    inner = "".join(map(drawn, tree)) or tree.text or ""
    return f"{tree.tag[1:]}[{inner}]" if tree.tag in ("mfrac", "msub", "msup", "mover", "msqrt") else inner


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("m g l / 2 a", "frac[mgl2a]"),
        ("1 + 3e/2L", "1+frac[3e2L]"),
        ("h/(l^2 (1 - u))", "frac[hsup[l2](1−u)]"),
        ("(a + b) / (c d) - e", "frac[a+bcd]−e"),
        ("(a)(b) / 2", "frac[(a)(b)2]"),  # two brackets stay, of which neither is that of the whole
        ("|A - B| / 2", "frac[|A−B|2]"),
        ("u'^2 = v_dot w_3^2", "sup[over[u˙]2]=over[v˙]sup[sub[ω3]2]"),
        ("4 I_w w + F_W", "4sub[Iw]ω+sub[FW]"),
        ("a'' + r_theta", "over[a¨]+sub[rθ]"),
        ("sin^2(b) x tan^(2k) c", "sup[sin2](b)×sup[tan2k]c"),
        ("2 sqrt(A / k)", "2sqrt[frac[Ak]]"),
        ("1 / c^4 b, not W ~ 1 / t", "frac[1sup[c4]b],notΩ∼frac[1t]"),
        ("f = atan2(B, A) +- 1 <= track", "f=atan2(B,A)±1≤track"),
        ("N = k s >= 0", "N=ks≥0"),
    ],
)
def test_structure(text, expected):
    assert drawn(trees(text)) == expected


def test_formulas_stand_below_each_other():
    assert [drawn(tree) for tree in trees("a = 1; b = 2 c")] == ["a=1", "b=2c"]


def test_what_html_would_read_is_escaped():
    assert drawn(trees('a < b & "c" > <i>')) == 'a<b&"c"><i>'


@pytest.mark.parametrize("text", ["2 (a + b", "sqrt 2", "|a"])
def test_an_open_bracket_is_named(text):
    with pytest.raises(ValueError, match=re.escape(f"formula '{text}'")):
        mathml(text)


@pytest.mark.parametrize("name", DEMOS)
def test_no_letter_of_a_demo_is_lost(name):
    """All letters and digits of the text, in order, are those of the formula."""
    text = re.sub("_d?dot|sqrt|(?<= )x(?= )", "", DEMOS[name].equation)
    text = re.sub(
        "_?[A-Za-z]+",
        lambda word: word[0][1:] if word[0] == "_w" else GREEK.get(word[0].lstrip("_"), word[0].lstrip("_")),
        text,
    )
    text = text.replace("_", " ")
    shown = "".join(trees(DEMOS[name].equation).itertext())
    assert not set(shown) & set("^_/*'")
    assert re.findall(r"\w", text) == re.findall(r"\w", re.sub(f"[{''.join(DOTS.values())}]", "", shown))
