"""Numbers and counts as text."""

from collections.abc import Iterable

from ..base.style import SUPERSCRIPTS

VALUE_ROUNDING = 1e-9  # [1] of the size of a quantity; smaller values are rounding


def digits(value: float, size: float = 0.0, count: int = 4) -> str:
    """Format a number with ``count`` significant digits; 0 if it is rounding of a value as large as ``size``."""
    if abs(value) <= VALUE_ROUNDING * size:
        return "0"
    return typeset(f"{value:.{count}g}")


def relative(value: float, count: int = 1) -> str:
    """Format a relative error or its limit: a power of ten, as the certificate writes it."""
    return typeset(f"{value:.{count - 1}e}") if value else "0"


def typeset(text: str) -> str:
    """Return a printed number with its power of ten raised."""
    if "e" in text:
        mantissa, exponent = text.split("e")
        power = f"10{str(int(exponent)).translate(SUPERSCRIPTS)}"
        text = {"1": power, "-1": f"-{power}"}.get(mantissa, f"{mantissa} · {power}")
    return text.replace("-", "−")


def triple(values: Iterable[float], size: float = 0.0) -> str:
    """Format the components of a vector; rounding beside the largest component is 0."""
    given = [float(value) for value in values]
    size = max(size, *map(abs, given))
    return "(" + ", ".join(digits(value, size) for value in given) + ")"
