"""Functions of time for drivers and forces."""

from .mechanism.signals import *
