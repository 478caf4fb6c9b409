"""Entry point of ``python -m mbsd3d.cli``, the same as ``mbsd3d``."""

from . import main

if __name__ == "__main__":
    main(prog_name="mbsd3d")
