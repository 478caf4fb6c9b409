"""Closed forms of beams, plates, mounts and cams, independent of the package that they check."""

from engines.closed_forms import cams
from engines.closed_forms.free_beam import bending_roots, bending_shape, torsion_shape
from engines.closed_forms.free_plate import free_plate
from engines.closed_forms.mounts import (
    bounce_and_pitch,
    quarter_car,
    skyhook_limit,
    three_coupled,
    transmissibility,
)
