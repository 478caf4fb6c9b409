"""Accelerations, state rates and projections: the kernels put together with the laws of the forces."""
