"""Shaded figures."""
