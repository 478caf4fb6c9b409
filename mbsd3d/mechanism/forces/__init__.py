"""Force elements: their parameters, and the records that the kernels read."""
