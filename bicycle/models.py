"""Bicycles as mechanisms: the public names of `model`."""

from .model.mechanism import Bicycle as Bicycle
from .model.mechanism import PublishedBody as PublishedBody
from .model.mechanism import outputs as outputs
from .model.mechanism import steer_torque as steer_torque
from .model.mechanism import whipple as whipple
