"""Loops that should not move."""
