"""Work against precision of `mbsd3d`, MuJoCo and Exudyn, and the speed of `mbsd3d` alone; ``python -m validation.benchmark``."""
