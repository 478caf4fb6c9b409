"""The body shell of a car as modes, and what its driver feels of the engine."""
