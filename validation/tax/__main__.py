"""``python -m validation.tax``."""

from validation.tax.cost import main

main(prog_name="python -m validation.tax")
