"""Foundations: checks of input, paths, rotations, inertia, errors, style, progress."""
