"""Entry point ``python -m validation``, the same as ``mbsd3d validate``."""

import sys

from mbsd3d.extend import main

if __name__ == "__main__":
    main(["validate", *sys.argv[1:]], prog_name="mbsd3d")
