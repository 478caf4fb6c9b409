"""Noise and vibration of real engines, from the crank to the cabin: on mounts, in cars, on roads."""
