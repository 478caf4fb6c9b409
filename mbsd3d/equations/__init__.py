"""From a mechanism to the tables of the kernels, and the plain dense solvers beside the fast ones."""
