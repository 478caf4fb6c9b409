"""``mbsd3d`` and ``python -m mbsd3d``: Ctrl-C is answered while the modules are still read, too."""

import sys

try:
    from .cli import main
except KeyboardInterrupt:
    sys.stderr.write("mbsd3d: interrupted\n")
    sys.exit(130)

if __name__ == "__main__":
    main(prog_name="mbsd3d")
