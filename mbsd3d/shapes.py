"""What bodies look like."""

from .mechanism.shapes import *
