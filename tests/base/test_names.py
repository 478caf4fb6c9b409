"""Names are texts of one line that read as they are: no signs that command a terminal or turn a text around."""

import unicodedata

import pytest

from mbsd3d import GROUND, Body, Force, Input, Revolute, System
from mbsd3d.base.checks import check_name

BOB = Body("bob", 1.0, (1.0, 1.1, 1.2), com=(0.1, 0.2, 0.3))
MAKERS = {
    "body": lambda name: Body(name, 1.0, (1.0, 1.1, 1.2)),
    "joint": lambda name: Revolute(GROUND, BOB, at=(0, 0, 0), axis=(0, 1, 0), name=name),
    "force": lambda name: Force(BOB, (1.0, 2.0, 3.0), name=name),
    "input": Input,
    "system": lambda name: System([BOB], name=name),
}
REFUSED = {
    "turned over": "safe\u202egnp.exe",
    "isolated": "a\u2066b\u2069",
    "embedded": "a\u202ab\u202c",
    "mark": "\u200fa",
    "arabic mark": "a\u061c",
    "end of line": "a\u2028b",
    "end of paragraph": "a\u2029b",
    "next line": "a\u0085b",
    "unseen": "bob\u200b",
    "byte order": "\ufeffbob",
    "word joiner": "bob\u2060",
    "tag": "bob\U000e0041",
    "escape": "a\x1b[2J",
}


@pytest.mark.parametrize("name", REFUSED.values(), ids=REFUSED)
@pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)
def test_what_reads_as_something_else_is_refused(make, name):
    with pytest.raises(ValueError, match="holds control characters; give a text of one line") as caught:
        make(name)
    assert str(caught.value).isprintable()  # the message does not do what the name would


@pytest.mark.parametrize(
    "name", ["Räder Ω", "車輪", "چرخ\u200cها", "שמאל", "👩\u200d🔧", "Ä\u0308 ½ µm²", "a b", "e\u0301"]
)
@pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)
def test_names_of_all_alphabets_are_kept(make, name):
    part = make(name)
    assert name in (part.name if hasattr(part, "name") else part.title, getattr(part, "title", None))


def test_the_kind_is_that_of_unicode():
    """All that turns the order of signs, and all ends of lines, by the properties that Unicode gives them."""
    turning = {"LRE", "RLE", "LRO", "RLO", "PDF", "LRI", "RLI", "FSI", "PDI"}
    signs = [chr(code) for code in range(0x110000)]
    for sign in signs:
        if unicodedata.category(sign) in ("Cc", "Zl", "Zp") or unicodedata.bidirectional(sign) in turning:
            with pytest.raises(ValueError, match="body"):
                check_name(f"a{sign}b", "body")
    check_name("".join(sign for sign in signs if unicodedata.category(sign)[0] in "LMNPS"), "body")
