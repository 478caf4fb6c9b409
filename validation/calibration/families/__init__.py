"""Families of problems: name -> function of a `Place` that draws one."""

from collections.abc import Callable

from validation.calibration.families import (
    chains,
    contacts,
    driven,
    events,
    free,
    loops,
    pulses,
    rolling,
    rotors,
    shafts,
    springs,
)
from validation.calibration.problem import Place, Problem

FAMILIES: dict[str, Callable[[Place], Problem]] = {
    make.__name__: make
    for module in (rotors, shafts, free, chains, loops, rolling, springs, contacts, pulses, events, driven)
    for make in module.FAMILIES
}
