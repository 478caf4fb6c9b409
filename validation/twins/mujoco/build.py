"""MuJoCo model of a layout: the tree of bodies and joints of the export, to which a counterpart model adds the rest."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from mbsd3d import GROUND, System
from mbsd3d.extend import LOCKED_SOLIMP, Layout, MujocoTree, NotExportable, mujoco_tree, text_of
from validation.twins.base import NotExpressible

# none is in a counterpart model, or one of no use
DISABLED_FLAGS = ("CONTACT", "LIMIT", "FRICTIONLOSS", "SENSOR", "ISLAND", "AUTORESET")
SOLVER_TOLERANCE, SOLVER_ITERATIONS = (
    1e-24,
    5,
)  # of the solver; a Newton step is exact, rounding calls for no more than five


@dataclass
class Sketch:
    """Model under construction: ``tree``, as exports write it, read into the specification ``spec``."""

    mujoco: Any
    system: System
    tree: MujocoTree
    spec: Any

    def __post_init__(self) -> None:
        self.layout, self.poses, self.joints = self.tree.layout, self.tree.poses, self.tree.joints
        self.closures, self.raised, self.held = self.tree.closures, self.tree.raised, self.tree.held

    def body(self, body: Any) -> Any:
        """Return the MuJoCo body that represents a body of the system."""
        return self.spec.worldbody if body is GROUND else self.spec.body(self.layout.main[id(body)].name)

    def site(self, body: Any, point: np.ndarray) -> str:
        """Return a site at a point of a body (world, reference pose), in the axes of the body."""
        self.tree.sites += 1
        return self.body(body).add_site(name=f"site {self.tree.sites}", pos=body.local_point(point)).name

    def equality(self, kind: str, part: Any, name: str, objects: tuple[str, str], of: str, data: tuple = ()) -> str:
        """Add an equality of a joint between two objects of a kind; return its name."""
        made = self.spec.add_equality(name=name, name1=objects[0], name2=objects[1])
        made.type = getattr(self.mujoco.mjtEq, f"mjEQ_{kind}")
        made.objtype = getattr(self.mujoco.mjtObj, f"mjOBJ_{of}")
        made.solimp[:] = LOCKED_SOLIMP
        made.data[: len(data)] = data
        self.held[name] = part
        return name


def sketch(mujoco: Any, system: System, layout: Layout, dense: bool) -> Sketch:
    """Build bodies, joints and loop closures."""
    try:
        tree = mujoco_tree(layout)
    except NotExportable as error:
        raise NotExpressible(str(error)) from None
    spec = mujoco.MjSpec.from_string(text_of(tree))
    for joint in spec.joints:
        joint.align = mujoco.mjtAlignFree.mjALIGNFREE_FALSE
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE if dense else mujoco.mjtJacobian.mjJAC_AUTO
    spec.option.disableflags = sum(int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{flag}")) for flag in DISABLED_FLAGS)
    spec.option.tolerance, spec.option.iterations = SOLVER_TOLERANCE, SOLVER_ITERATIONS
    return Sketch(mujoco, system, tree, spec)
