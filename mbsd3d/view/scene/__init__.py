"""Scene of a mechanism: pieces, poses over time, arrows, traces."""
