"""Teeth in space."""

PLACE = 7
