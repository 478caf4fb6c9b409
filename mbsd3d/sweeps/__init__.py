"""One mechanism over a grid of parameters."""
