"""What planar mechanisms cost in space: ``python -m validation.tax``."""
