"""Nonlinear runs of a bicycle, and their results."""
