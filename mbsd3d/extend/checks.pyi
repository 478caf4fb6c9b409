# values
from ..base.checks import number as number
from ..base.checks import whole as whole
from ..base.checks import vector as vector
from ..base.checks import solvable as solvable
from ..base.mass_properties import check_inertia as check_inertia

# systems and states
from ..run.simulation import check_system as check_system
from ..run.simulation import check_state as check_state
from ..run.simulation import check_signals as check_signals
from ..equations.at_state import check_quaternions as check_quaternions

# calls, names and packages
from ..base.errors import Explained as Explained
from ..base.errors import explaining as explaining
from ..base.errors import similar as similar
from ..base.version import loading as loading
