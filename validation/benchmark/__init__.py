"""Work against precision of `mbsd3d` and its peers, and the speed of `mbsd3d` alone; ``python -m
validation.benchmark``.
"""
