"""Tables of the kernels from a mechanism, and plain dense solvers beside the fast ones."""
