"""Rank, redundant joints and their remedies, closed poses and consistent velocities."""
