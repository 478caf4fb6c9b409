"""Model files, solution files, tables."""
