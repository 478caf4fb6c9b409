# values
from ..base.checks import number as number
from ..base.checks import whole as whole
from ..base.checks import vector as vector
from ..base.checks import reporting_linalg_errors as reporting_linalg_errors
from ..base.mass_properties import check_inertia as check_inertia

# systems and states
from ..run.simulation import check_system as check_system
from ..run.simulation import check_state as check_state
from ..run.simulation import check_signals as check_signals
from ..equations.at_state import check_quaternions as check_quaternions

# calls, names and packages
from ..base.errors import ChecksArguments as ChecksArguments
from ..base.errors import checks_arguments as checks_arguments
from ..base.errors import similar as similar
from ..base.version import loading as loading
