"""Engines with real dimensions, as `engines.balance.Engine` with the other data of a powertrain.

The rod is known by mass and length; its centre of mass lies at `ROD_FRACTION` of the length from the crankpin and its
inertia is that of two masses at the ends over `ROD_INERTIA_RATIO`, the average of measured rods. Counterweights
carry all that turns with the pin and the share ``balanced`` of what goes with the piston:

    m_c r_c = -((1 - f) m_r + balanced (m_p + f m_r)) R

>>> preset("inline_4").engine(3000).layout.firing_order
'1-3-4-2'
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from engines.balance.gas import firing_order
from engines.balance.layouts import Engine, Layout, layout
from engines.balance.layouts import names as layout_names
from engines.nvh.records import Record, data, fields, is_file, positive, record, titled, triple
from mbsd3d import inertia, rotation
from mbsd3d.errors import InputError
from mbsd3d.extend import matrix, number

POSITIVE_FIELDS = (
    "bore", "stroke", "rod_length", "spacing", "idle", "redline", "compression", "piston_mass", "rod_mass",
    "throw_mass", "flywheel", "main_diameter", "main_width", "roller_rating",
)  # fmt: skip
LAYOUT_FIELDS = ("pins", "bores", "stations", "firing_order")  # of an engine whose layout has no name
ROD_FRACTION, ROD_INERTIA_RATIO = 0.28, 1.0965
THROW_INERTIA_RATIOS = (0.5, 0.5, 0.8)  # [1] inertia of a throw with counterweights over its mass times R^2, axis last


@dataclass(frozen=True)
class Block:
    """All parts of a powertrain that do not move relative to its block.

    ``mass`` [kg]; ``box`` (3,): edges of the uniform box of its inertia [m]; ``com`` (3,): from the middle of the
    crank, x along it, z up [m]; ``tilt``: of the box about y [degrees].
    """

    mass: float
    box: tuple[float, float, float]
    com: tuple[float, float, float]
    tilt: float

    def __post_init__(self) -> None:
        number(self.mass, "block: mass", positive=True)
        triple(self.box, "block: box", positive=True)
        triple(self.com, "block: com")
        number(self.tilt, "block: tilt")

    @property
    def inertia(self) -> np.ndarray:
        """Return the inertia about the centre of mass [kg m^2], shape (3, 3)."""
        R = matrix(rotation("y", self.tilt, degrees=True))
        return R @ np.diag(inertia.box(self.mass, self.box)) @ R.T


@dataclass(frozen=True)
class Preset:
    """An engine; lengths [m], masses [kg], speeds [1/min], fields as in the data file.

    ValueError for a title that is not a text, a number that is not positive, or an idle speed that is not below the
    redline.
    """

    name: str
    title: str
    layout: Layout
    bore: float
    stroke: float
    rod_length: float
    spacing: float
    idle: float
    redline: float
    compression: float
    piston_mass: float
    rod_mass: float
    throw_mass: float
    balanced: float
    flywheel: float
    main_diameter: float
    main_width: float
    roller_rating: float
    block: Block

    def __post_init__(self) -> None:
        what = f"engine '{self.name}'"
        titled(self.title, what)
        positive(vars(self), POSITIVE_FIELDS, what)
        number(self.balanced, f"{what}: balanced", minimum=0.0)
        if not self.idle < self.redline:
            raise InputError(
                f"{what}: idle {self.idle:g} is not below the redline {self.redline:g} 1/min; give a lower one"
            )

    @property
    def displacement(self) -> float:
        """Return the displacement of all cylinders [m^3]."""
        return len(self.layout.pins) * np.pi / 4 * self.bore**2 * self.stroke

    def engine(self, rpm: float) -> Engine:
        """Return the engine at a speed [1/min] > 0; raise ValueError for others."""
        rpm = number(rpm, f"engine '{self.name}': rpm", positive=True)
        R, f = self.stroke / 2, ROD_FRACTION
        carried = (1 - f) * self.rod_mass + self.balanced * (self.piston_mass + f * self.rod_mass)
        return Engine(
            self.layout, rpm=rpm, radius=R, rod_length=self.rod_length, crank_mass=self.throw_mass,
            crank_centre=-carried * R / self.throw_mass, rod_mass=self.rod_mass, rod_fraction=f,
            rod_inertia=f * (1 - f) * self.rod_mass * self.rod_length**2 / ROD_INERTIA_RATIO,
            piston_mass=self.piston_mass,
            spacing=self.spacing,
        )  # fmt: skip


def names() -> tuple[str, ...]:
    """Return the names of all engines of the data file."""
    return tuple(data("engines")["engines"])


def preset(name: str) -> Preset:
    """Return an engine by its name, or from a file (.json) with the same fields; raise ValueError for others."""
    if name in layout_names() and name not in names():
        raise InputError(
            f"'{name}' is a layout of the toy engine (python -m engines.balance {name}); "
            f"engines with real dimensions are {', '.join(names())}"
        )
    found, title = dict(record("engines", name)), Path(name).stem if is_file(name) else name
    what = f"engine '{title}'"
    shape = ("layout",) if "layout" in found else LAYOUT_FIELDS
    fields(found, ("title", *POSITIVE_FIELDS, "balanced", "block", *shape), what)
    fields(found["block"], ("mass", "box", "com", "tilt"), f"{what}: block")
    parts = {key: found.pop(key) for key in shape}
    plan = layout(parts["layout"]) if "layout" in parts else own_layout(title, found, parts)
    return Preset(name=title, layout=plan, block=Block(**found.pop("block")), **found)


def own_layout(name: str, found: Record, parts: Record) -> Layout:
    """Return the layout of cylinders given one by one; raise ValueError for a firing order that the crank cannot
    have."""
    plan = Layout(name, found["title"], spacing=found["spacing"], **parts)
    if plan.firing_order is not None:
        order = plan.firing_order.split("-")
        first = order.index("1")
        if (does := firing_order(plan)) != "-".join(order[first:] + order[:first]):
            given = plan.firing_order
            raise InputError(f"engine '{name}': firing_order {given} does not suit its pins and bores; {does} does")
    return plan
