"""On the road."""

PLACE = 7
