"""Shafts out of line."""
