"""What can be measured of a mechanism."""

from .mechanism.measures import *
