"""What forgotten terms break."""

PLACE = 11
