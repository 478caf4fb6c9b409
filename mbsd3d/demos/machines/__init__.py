"""Machines as they are built."""

PLACE = 8
