"""Entry point of ``python -m validation.benchmark``."""

from validation.benchmark.cli import main

main()
