"""Solvers for comparison: a planar one with no equation in common with ``mbsd3d``, and twins in MuJoCo and Exudyn."""
