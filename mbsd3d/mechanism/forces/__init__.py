"""Force elements: what they are given, and the record that the kernels read."""

from ..force_element import ForceElement
from .custom import CustomForce
from .feedback import StateFeedback
from .loads import AeroDrag, Force, Torque
from .springs import Bushing, JointFriction, SpringDamper, TorsionSpring
