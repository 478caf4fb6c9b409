"""``python -m mbsd3d.cli`` is ``mbsd3d``."""

from . import main

main(prog_name="mbsd3d")
