"""A mechanism of anyone's in other engines: `cross_check`.

Read in this order: `quantities` (what is compared), `limits` (convergence), `ours`, `ladder`, `start`, `judge`,
`causes` (attribution), `formulation` (the joints' definitions), `check`; `verdict` and `display` hold the result.
"""

from validation.crosscheck.check import ENGINES, cross_check
from validation.crosscheck.result import Attribution, Compared, CrossCheck, Curve, Finding
