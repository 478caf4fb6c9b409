"""Shafts out of line."""

PLACE = 6
