"""What forgotten terms break."""

PLACE = 8
