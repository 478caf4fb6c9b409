"""``python -m mbsd3d.cli`` is ``mbsd3d``."""

from . import main

if __name__ == "__main__":
    main(prog_name="mbsd3d")
