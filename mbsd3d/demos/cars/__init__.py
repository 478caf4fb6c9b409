"""A car at the limit of its tyres."""

PLACE = 10
