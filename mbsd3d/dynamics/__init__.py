"""Accelerations, state rates and projections, compiled from the kernels and the force laws."""
