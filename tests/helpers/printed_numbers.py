"""Numbers as pages print them, read back."""

import re

RAISED = "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"


def number(text: str) -> float:
    """A number as it is set, 1.5 · 10⁻³, −10⁶ or −18\u202f140, as a float."""
    plain = text.replace("−", "-").replace("\u202f", "").replace(" ", "")
    mantissa, power = re.fullmatch(rf"(.*?)(?:·?10([{RAISED}]+))?", plain).groups()
    factor = {"": "1", "-": "-1"}.get(mantissa, mantissa)
    return float(factor) * 10.0 ** int((power or "0").translate(str.maketrans(RAISED, "-0123456789")))
