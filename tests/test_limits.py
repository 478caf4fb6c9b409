"""Limits of the tests are those that are written: numpy's own tolerances hide one that is given alone."""

import ast
from pathlib import Path

CLOSE = {"allclose", "assert_allclose", "isclose"}
"""They allow ``atol + rtol |b|``: 1e-5 of ``b`` (1e-7, assert_allclose) beside an absolute limit of rounding."""


def half_given(source: str) -> list[int]:
    """Lines where one of both tolerances is given; the relative one of ``assert_allclose`` may stand alone."""
    found = []
    for node in ast.walk(ast.parse(source)):
        name = ast.unparse(node.func).rpartition(".")[2] if isinstance(node, ast.Call) else ""
        given = {key.arg for key in node.keywords} & {"rtol", "atol"} if name in CLOSE else set()
        if given == {"atol"} or (given == {"rtol"} and name != "assert_allclose"):
            found.append(node.lineno)
    return found


def test_both_tolerances_are_given():
    for path in sorted(Path(__file__).parent.rglob("*.py")):
        lines = half_given(path.read_text(encoding="utf-8"))
        assert not lines, f"{path.name}, lines {lines}: say rtol=0 beside atol, or atol=0 beside rtol"


def test_ablation_one_of_both_is_seen():
    assert half_given("np.allclose(a, b, atol=1e-15)\nnp.isclose(a, b, rtol=1e-9)\nassert_allclose(a, b)") == [1, 2]
    assert half_given("allclose(a, b, rtol=0, atol=LIMIT)\nnp.testing.assert_allclose(a, b, rtol=1e-9)") == []
