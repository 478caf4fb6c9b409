"""Force elements: what they are given, and the record that the kernels read."""
