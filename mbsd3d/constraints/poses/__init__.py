"""Poses that meet joints, drivers and asked-for values, found along the motion of the mechanism."""
