"""What forgotten terms break."""

PLACE = 9
