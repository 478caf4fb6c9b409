# classes
from ..base.fields import part_class as part_class
from ..base.fields import kept as kept
from ..base.fields import Checked as Checked
from ..base.fields import derive as derive

# kinds of fields
from ..base.fields import Stored as Stored
from ..base.fields import Number as Number
from ..base.fields import NumberOrDerived as NumberOrDerived
from ..base.fields import NumberOrNone as NumberOrNone
from ..base.fields import Vector as Vector
from ..base.fields import Direction as Direction
