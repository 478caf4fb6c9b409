"""Nonlinear runs of a bicycle, and what they show."""
