"""What this package raises, all of it an `MbsError`: wrong input is an `InputError`, the others are failures."""

from .base.errors import ArgumentError as ArgumentError
from .base.errors import AssemblyError as AssemblyError
from .base.errors import EquilibriumError as EquilibriumError
from .base.errors import GradientError as GradientError
from .base.errors import InputError as InputError
from .base.errors import IntegrationError as IntegrationError
from .base.errors import KernelError as KernelError
from .base.errors import MbsError as MbsError
from .base.errors import NameMissingError as NameMissingError
from .base.errors import SweepError as SweepError
