"""Layers: what is shown and hidden together, by the same names in pages, pictures and films."""

from collections.abc import Collection, Iterable
from typing import Any

ARROWS = ("angular velocity", "angular momentum", "reaction force", "reaction moment")
NAMES = ("body names", "joint names")
MARKS = ("centre of mass", "reference point")
USUAL = ("bodies", "joints", "springs and rods", "traces", "ground grid")
LAYERS = (
    "bodies", "body names", "joints", "joint names", "springs and rods", "traces", "ground grid", *ARROWS, *MARKS,
)  # fmt: skip


def layers_of(shown: Any, hidden: Any, usual: Collection[str] = USUAL) -> tuple[str, ...]:
    """The layers that are to be seen, in their order: the usual ones, besides them ``shown``, and never ``hidden``.

    Raises
    ------
    ValueError
        Naming the option, for an unknown layer or one that is to be shown and hidden.
    """
    more, less = known(shown, "shown"), known(hidden, "hidden")
    for layer in more:
        if layer in less:
            raise ValueError(f"shown, hidden: layer {layer!r} stands in both; take it out of one")
    return tuple(layer for layer in LAYERS if (layer in usual or layer in more) and layer not in less)


def known(wanted: Any, option: str) -> tuple[str, ...]:
    """Names of layers, checked; a single one may stand alone."""
    if not isinstance(wanted, Iterable):
        raise ValueError(f"{option} = {wanted!r}; give a list of layers, e.g. ['angular velocity']")
    wanted = (wanted,) if isinstance(wanted, str) else tuple(wanted)
    for layer in wanted:
        if layer not in LAYERS:
            raise ValueError(f"{option}: layer {layer!r} is unknown; give some of {', '.join(LAYERS)}")
    return wanted
