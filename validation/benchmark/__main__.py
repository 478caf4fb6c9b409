"""``python -m validation.benchmark``."""

from .cli import main

main()
