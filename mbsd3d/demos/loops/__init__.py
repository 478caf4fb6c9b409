"""Loops that should not move."""

PLACE = 5
