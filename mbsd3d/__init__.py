"""Spatial multibody dynamics in reference coordinates, written like the textbook and checked like an instrument."""

from importlib import import_module

__version__ = "0.1.0"

_HOME = {
    "parts": ("Body", "GROUND"),
    "system": ("System",),
    "state": ("State",),
    "rotations": ("rotation",),
    "joints": (
        "ConstantVelocity", "Cylindrical", "Distance", "Fixed", "Joint", "Parallel", "Perpendicular", "Planar",
        "PointOnLine", "PointOnPlane", "Prismatic", "Revolute", "Screw", "Spherical", "Universal",
    ),
    "couplings": ("Gear", "GearMesh", "RackPinion"),
    "bearings": ("bearing_load", "bearing_pair"),
    "ratings": ("DeepGrooveBallBearing", "RollingBearing", "reliability_factor"),
    "contacts": ("KnifeEdge", "RollingDisc"),
    "drivers": ("AngleDriver", "Driver", "PositionDriver", "SlideDriver", "SpeedDriver"),
    "forces": ("AeroDrag", "Bushing", "Force", "JointFriction", "SpringDamper", "TorsionSpring", "Torque"),
    "signals": ("Constant", "Polynomial", "Pulse", "Ramp", "Signal", "Sine", "Table"),
    "simulation": ("accelerations", "simulate"),
    "linearization": ("Linearization", "linearize"),
    "modes": ("Mode",),
    "solution": ("Solution",),
    "files": ("load",),
    "importers": ("read_mjcf", "read_urdf"),
    "imported": ("Imported",),
    "sweeps": ("sweep",),
    "grids": ("Samples", "samples"),
    "errors": ("AssemblyError", "IntegrationError", "SweepError"),
    "integrators.dop853": ("DOP853",),
    "integrators.rk4": ("RK4",),
    "integrators.driven": ("Kinematic",),
    "integrators.generalized_alpha": ("GeneralizedAlpha",),
    "feedback": ("StateFeedback",),
    "custom": ("CustomForce",),
}  # fmt: skip
_MODULES = ("inertia", "measures", "shapes", "signals", "rotations")
_WHERE = {name: module for module, names in _HOME.items() for name in names}

__all__ = [*_WHERE, *_MODULES]


def __getattr__(name: str):
    """Import a public name on first use, so that the command line starts fast."""
    if name in _WHERE:
        value = getattr(import_module(f".{_WHERE[name]}", __name__), name)
    elif name in _MODULES:
        value = import_module(f".{name}", __name__)
    else:
        raise AttributeError(f"module 'mbsd3d' has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
