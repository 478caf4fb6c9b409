"""Cross-check of any mechanism with other engines: `cross_check`.

Read in this order: `ours` (what is compared), `ladder` (convergence), `judge`, `formulation` (the joints' definitions),
`check`; `result` is what it returns.
"""

from validation.crosscheck.check import ENGINES, cross_check
from validation.crosscheck.result import Attribution, Compared, CrossCheck, Curve, Finding
