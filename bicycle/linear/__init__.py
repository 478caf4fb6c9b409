"""Small motions about a straight run: linear equations, critical speeds, and studies built on them."""
