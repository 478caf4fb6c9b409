"""Solvers written for comparison, with no equation in common with ``mbsd3d``: a planar one."""
