"""Spin turns sideways."""

PLACE = 1
