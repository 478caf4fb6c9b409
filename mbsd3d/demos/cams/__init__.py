"""Cams and grooves."""

PLACE = 8
