from . import checks as checks
from . import commands as commands
from . import demos as demos
from . import dynamics as dynamics
from . import fields as fields
from . import figures as figures
from . import live as live
from . import trees as trees
from .checks import *
from .commands import *
from .demos import *
from .dynamics import *
from .fields import *
from .figures import *
from .live import *
from .trees import *
