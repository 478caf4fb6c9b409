"""Simulation: from a mechanism and a method to the samples of its motion."""
