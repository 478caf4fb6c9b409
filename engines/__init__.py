"""Engines from the gas in their cylinders to the seat rail: balance, noise and vibration, the planar solver."""
