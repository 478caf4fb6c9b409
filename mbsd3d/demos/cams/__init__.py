"""Cams and grooves."""

PLACE = 7
