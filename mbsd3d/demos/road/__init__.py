"""On the road."""

PLACE = 8
