"""Public names that are imported on first use, from one list: the stub beside a module, which editors read too."""

import ast
from collections.abc import Callable
from importlib import import_module
from importlib.util import resolve_name
from pathlib import Path
from types import MappingProxyType
from typing import Any

# What other programs call parts and functions: name -> what that is here.
NAMES_ELSEWHERE = MappingProxyType({
    "Hinge": "Revolute", "HingeJoint": "Revolute", "RevoluteJoint": "Revolute", "Pin": "Revolute",
    "PinJoint": "Revolute", "Continuous": "Revolute", "Weld": "Fixed", "WeldJoint": "Fixed", "FixedJoint": "Fixed",
    "Rigid": "Fixed", "Ball": "Spherical", "BallJoint": "Spherical", "SphericalJoint": "Spherical",
    "Slide": "Prismatic", "Slider": "Prismatic", "SliderJoint": "Prismatic", "PrismaticJoint": "Prismatic",
    "Translational": "Prismatic", "Hooke": "Universal", "Cardan": "Universal", "UniversalJoint": "Universal",
    "Convel": "ConstantVelocity", "Rod": "Distance", "DistanceJoint": "Distance", "Inline": "PointOnLine",
    "Inplane": "PointOnPlane", "CylindricalJoint": "Cylindrical", "PlanarJoint": "Planar", "ScrewJoint": "Screw",
    "Helical": "Screw",
    "Motor": "AngleDriver or SpeedDriver (a motion), Torque with an Input or TorqueCurve (a torque)",
    "Motion": "AngleDriver, SlideDriver or PositionDriver", "Actuator": "LinearActuator, or a Torque with an Input",
    "Servo": "StateFeedback, or a Torque with an Input set through Stepper",
    "PID": "StateFeedback, or a Torque with an Input set through Stepper", "Spring": "SpringDamper",
    "Damper": "SpringDamper", "TSDA": "SpringDamper", "RSDA": "TorsionSpring", "RotationalSpring": "TorsionSpring",
    "Mount": "Bushing", "Bush": "Bushing", "BISTOP": "EndStop", "Stop": "EndStop",
    "Cable": "Rope", "Sheave": "Pulley", "Drum": "Winch",
    "Friction": "Brake or JointFriction", "Mate": "a joint: Revolute, Prismatic, Fixed, ...", "Link": "Body",
    "Part": "Body", "RigidBody": "Body", "Model": "System", "MultibodySystem": "System",
    "World": "GROUND, in a System", "Ground": "GROUND", "Marker": "none: joints take at= and axis=",
    "Track": "CurveContact", "Cam": "CurveContact", "Wheel": "Rolling, RollingDisc or Tyre", "Tire": "Tyre",
    "Chart": "solution.plot()", "solve": "simulate", "integrate": "simulate", "run": "simulate",
    "eigenfrequencies": "linearize(system, state).modes", "eigenvalues": "linearize(system, state).eigenvalues",
})  # fmt: skip


def attach(module: dict[str, Any]) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """``__getattr__``, ``__dir__`` and ``__all__`` of a module, given its ``globals()``.

    Its stub says where each name lives: ``from .place import name as name``, ``from . import name as name``,
    ``from package.place import name as name`` for one of a package beside, ``from .part import *`` for all of another
    such module of its package.
    """
    places = places_of(Path(module["__file__"]).with_suffix(".pyi"))
    names = sorted(places)

    def load(name: str) -> Any:
        """The object of a name."""
        if name not in places:
            raise unknown(module["__name__"], name)
        place, own = places[name]
        package = module["__spec__"].parent
        if place == ".":
            module[name] = import_module(f".{own}", package)
        else:  # `own` may be in that module, or be a module itself
            module[name] = getattr(__import__(resolve_name(place, package), fromlist=[own]), own)
        return module[name]

    return load, names.copy, names


def unknown(module: str, name: str) -> Exception:
    """Return the error of a name that a module does not have.

    Of names of other programs it is an ImportError: ``from mbsd3d import Weld`` keeps no text of an AttributeError.
    """
    if module == __package__ and name in NAMES_ELSEWHERE:
        return ImportError(f"{module} has no {name!r}; here that is {NAMES_ELSEWHERE[name]}", name=name)
    return AttributeError(f"module {module!r} has no attribute {name!r}")


def places_of(stub: Path) -> dict[str, tuple[str, str]]:
    """Return name -> (module, name there) of all names that a stub lists."""
    tree = ast.parse(stub.read_text(encoding="utf-8"))
    places: dict[str, tuple[str, str]] = {}
    for node in (node for node in tree.body if isinstance(node, ast.ImportFrom)):
        place = "." * node.level + (node.module or "")
        if node.names[0].name == "*":
            places |= {name: (place, name) for name in places_of(stub.parent / f"{node.module}.pyi")}
        else:
            places |= {alias.asname or alias.name: (place, alias.name) for alias in node.names}
    return places
