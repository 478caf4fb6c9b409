"""Tops, coins and stones."""
