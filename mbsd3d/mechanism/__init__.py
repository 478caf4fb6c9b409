"""Data of a mechanism: bodies, joints, drivers, forces, signals and measures."""
