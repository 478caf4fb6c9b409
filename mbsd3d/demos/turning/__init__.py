"""Turning does not add up."""
