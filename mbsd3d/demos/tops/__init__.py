"""Tops, coins and stones."""

PLACE = 3
