"""Small motions about a straight run: linear equations, critical speeds, and the studies built on them."""
