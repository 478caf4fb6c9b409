"""``python -m validation.engine_balance``."""

from validation.engine_balance.cli import main

main(prog_name="python -m validation.engine_balance")
