"""Work against precision of `mbsd3d` and its peers, and our speed alone; ``python -m validation.benchmark``."""
