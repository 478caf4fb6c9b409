"""``python -m validation.engine_balance``."""

from .cli import main

main(prog_name="python -m validation.engine_balance")
