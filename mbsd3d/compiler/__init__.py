"""How the kernels are compiled: once, kept on disk, called by address."""
