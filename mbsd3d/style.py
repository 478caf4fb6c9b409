"""The house style: colours that are told apart with any colour vision, on light and on dark paper."""

# Okabe and Ito's colours; black and yellow are left out: axes and paper
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#E69F00", "#56B4E9", "#CC79A7")
GREY = "#707070"


def colour(i: int) -> str:
    """Colour of body or line ``i``."""
    return COLOURS[i % len(COLOURS)]
