"""What can be measured of a mechanism: scalar functions of its state, named by part.

One vocabulary: `solution.measure`, curves of plots, reports and pages, ``stop_when``, `StateFeedback`, targets of
`System.assemble` and outputs of `linearize` all take them.
"""

from .mechanism.measures import Condition as Condition
from .mechanism.measures import Measure as Measure
from .mechanism.measures import angle as angle
from .mechanism.measures import angle_between as angle_between
from .mechanism.measures import between as between
from .mechanism.measures import camber as camber
from .mechanism.measures import clearance as clearance
from .mechanism.measures import distance as distance
from .mechanism.measures import heading as heading
from .mechanism.measures import heading_rate as heading_rate
from .mechanism.measures import lean as lean
from .mechanism.measures import lean_rate as lean_rate
from .mechanism.measures import leaves as leaves
from .mechanism.measures import length as length
from .mechanism.measures import normal_force as normal_force
from .mechanism.measures import offset as offset
from .mechanism.measures import offset_rate as offset_rate
from .mechanism.measures import omega as omega
from .mechanism.measures import position as position
from .mechanism.measures import rate as rate
from .mechanism.measures import reaction as reaction
from .mechanism.measures import slide as slide
from .mechanism.measures import slide_rate as slide_rate
from .mechanism.measures import state as state
from .mechanism.measures import tension as tension
from .mechanism.measures import touches as touches
from .mechanism.measures import turn as turn
from .mechanism.measures import turn_rate as turn_rate
from .mechanism.measures import velocity as velocity
