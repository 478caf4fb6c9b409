"""Entry point of ``python -m validation.calibration``."""

from validation.calibration.cli import main

main()
