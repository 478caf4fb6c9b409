"""Numbers, units and counts as people read them: on pages, in figures, in tables and in messages.

Files for programs keep all digits and ASCII. What is written for a terminal in ASCII, ``5.6e-16 m/s^2``, becomes
``5.6 · 10⁻¹⁶ m/s²`` on a page by `readable`.
"""

import re
from collections.abc import Iterable

VALUE_ROUNDING = 1e-9  # [1] of the size of a quantity; smaller values are rounding
PLAIN_MAX = 1e6  # [1] numbers below it are written without a power of ten
COMPARED_DIGITS = 6  # [1] of numbers that stand side by side; files for programs have all
THIN_SPACE = "\u202f"  # narrow and without a line break: groups of three digits
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
TYPOGRAPHY: tuple[tuple[re.Pattern[str], str], ...] = (
    (re.compile(r"(?<=/)(mm|cm|m|s)([234])\b"), r"\1^\2"),  # mm/s2
    (re.compile(r"\b(mm|cm|kg m)([234])\b"), r"\1^\2"),  # cm3
    (re.compile(r"(?<![\w.,)\]^⁻])-(?=[\d.∞])"), "−"),
    (re.compile(r"(?<=\d) x (?=\d)"), " × "),
    (re.compile(r"(?<=\d) (?=\d{3}\b)"), THIN_SPACE),  # 18 140 stays on its line
)
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
POWER_OF_TEN = re.compile(r"(?<![\w.])(\d+(?:\.\d+)?)e([-+]?\d+)(?![\w.]*\w)")
AN_BEFORE = re.compile(r"'?(?:[aeiouAEIOU]|[FHLMNRSX][A-Z\d]|8|1[18]\b)")  # as it is spoken: an FMU, an RSSR
A_BEFORE = re.compile(r"'?(?:[Uu]ni|[Uu]se|[Ee]u|one\b|U[A-Z])")
PLURALS = (("ay", "ays"), ("ey", "eys"), ("y", "ies"), ("axis", "axes"), ("x", "xes"), ("ss", "sses"), ("ch", "ches"))


def digits(value: float, size: float = 0.0, count: int = 4) -> str:
    """Format a number with ``count`` significant digits; 0 if it is rounding of a value as large as ``size``."""
    if abs(value) <= VALUE_ROUNDING * size:
        return "0"
    text = f"{value:.{count}g}"
    if "e+" in text and abs(float(text)) < PLAIN_MAX:
        text = f"{float(text):.0f}"
    return typeset(text)


def relative(value: float, count: int = 1) -> str:
    """Format a relative error or its limit: a power of ten, as the certificate writes it."""
    return typeset(f"{value:.{count - 1}e}") if value else "0"


def typeset(text: str) -> str:
    """Return a printed number with its power of ten raised and its digits in groups of three."""
    if "e" in text:
        mantissa, exponent = text.split("e")
        power = f"10{str(int(exponent)).translate(SUPERSCRIPTS)}"
        text = {"1": power, "-1": f"-{power}"}.get(mantissa, f"{mantissa} · {power}")
    elif len(text.partition(".")[0].lstrip("-")) > 4 and text.lstrip("-")[0].isdigit():
        whole, point, rest = text.partition(".")
        text = f"{int(whole):,}".replace(",", THIN_SPACE) + point + rest
    return text.replace("-", "−")


def triple(values: Iterable[float], size: float = 0.0) -> str:
    """Format the components of a vector; rounding beside the largest component is 0."""
    given = [float(value) for value in values]
    size = max(size, *map(abs, given))
    return "(" + ", ".join(digits(value, size) for value in given) + ")"


def error_text(value: float, count: int = 2) -> str:
    """Format an error for a terminal, ``5.6e-16``: 0 is 0, since ``0.0e+00`` tells nothing more."""
    return f"{value:.{count - 1}e}" if value else "0"


def with_superscripts(text: str) -> str:
    """Write ``m/s²`` for ``m/s^2``, where text is set for reading."""
    return re.sub(r"\^(-?\d+)", lambda power: power[1].translate(SUPERSCRIPTS), text)


def readable(text: str) -> str:
    """Return a text of a terminal as it is set on a page: powers of ten, minus signs, thin spaces and SI units.

    ``-5.6e-16 mm/s2`` becomes ``−5.6 · 10⁻¹⁶ mm/s²``; signs within names, ``inline-4``, stay.
    """
    if NUMBER.fullmatch(text):
        return typeset(text)
    text = POWER_OF_TEN.sub(lambda found: typeset(found[0]), text)
    for typed, printed in TYPOGRAPHY:
        text = typed.sub(printed, text)
    return with_superscripts(text)


def yes_or_no(value: object) -> str:
    """Return ``yes`` or ``no``."""
    return "yes" if value else "no"


def counted(number: float, word: str) -> str:
    """Write a number with its noun: ``1 body``, ``2 bodies``, ``1 mesh file``, ``3 axes`` of ``axis``."""
    if number != 1:
        word = next((word[: -len(end)] + ends for end, ends in PLURALS if word.endswith(end)), word + "s")
    return f"{number} {word}"


def with_article(name: str) -> str:
    """Write a name with its article as one speaks it: ``a Revolute``, ``an AngleDriver``, ``an FMU``.

    Examples
    --------
    >>> with_article("Universal"), with_article("AngleDriver"), with_article("URDF")
    ('a Universal', 'an AngleDriver', 'a URDF')
    """
    return f"{'an' if AN_BEFORE.match(name) and not A_BEFORE.match(name) else 'a'} {name}"
