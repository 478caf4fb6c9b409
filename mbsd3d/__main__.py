"""``python -m mbsd3d`` is ``mbsd3d``."""

from .cli import main

if __name__ == "__main__":
    main(prog_name="mbsd3d")
