"""Entry point of ``python -m engines.balance``."""

from engines.balance.cli import main

main(prog_name="python -m engines.balance")
