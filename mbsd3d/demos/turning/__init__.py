"""Turning does not add up."""

PLACE = 4
