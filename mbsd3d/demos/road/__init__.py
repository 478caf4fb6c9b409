"""On the road."""

PLACE = 9
