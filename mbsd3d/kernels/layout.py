"""Tables that the kernels read and write: `Model` (constant), `Data` (work space), `Tree` (for the saddle point).

Tables are arrays of records: ``m.body[i].mass``, ``d.row[k].gamma``; from Python ``data.row["gamma"]`` is the whole
column. Vectors are in world axes unless a line says "body axes"; SI units. Body index n (one past the last) is the
ground: it has a pose and zero velocity in `Data`, and no columns in the equations.
"""

from functools import cache
from typing import NamedTuple

import numba
import numpy as np

from ..compiler.arguments import by_reference

ADDRESS = object if numba.config.DISABLE_JIT else np.int64  # without the compiler: the function itself
CUSTOM_FORCE_BODIES_MAX = 4  # [bodies] a custom force acts on


BODY = [
    ("mass", float),  # kg
    ("inv_mass", float),  # 1/kg, zero of a body whose mass or inertia is singular,
    ("com", float, 3),  # m, r_G from the reference point O, body axes
    ("inertia", float, 9),  # kg m^2, about the centre of mass, body axes
    ("inv_inertia", float, 9),  # I_G^-1, body axes; zero as well
    ("symmetry", int),  # 1: two equal moments, and the reference point on the axis of the third; 2: three; else 0
    ("axis", float, 3),  # that axis, body axes
]
PRIMITIVE = [
    ("kind", int),  # one of the constants of kinds.py
    ("row", int),  # first of its rows
    ("rows", int),  # number of its rows
    ("body", int, 4),  # bodies of its slots, -1 = unused slot
    ("point", float, (4, 3)),  # m, a point in each slot's body, body axes from O
    ("axis", float, (4, 3)),  # a unit vector in each slot's body, body axes
    ("second_axis", float, (4, 3)),  # a second one
    ("value", float, 4),  # scalars: distance, ratios, radii
    ("coordinate", int, 4),  # hinge coordinates of a ratio or coupler, -1 = unused
    ("number", int),  # first of its numbers in Model.number
    ("numbers", int),  # how many there are
    ("signal", int),  # prescribed motion, -1 = none
]
ROW = [
    ("body", int, 4),  # bodies of the slots, -1 = unused
    ("holonomic", int),  # 1: has a residual c(q, t); 0: velocities only
    ("metres", int),  # 1: measured in metres; 0: in radians, so that it turns bodies and moves no point
    ("scale", float),  # 1/length for rows in metres, 1 for radians
    ("drive", int),  # number of the driven row (its work is a state), -1 = not driven
]
COORDINATE = [
    ("kind", int),  # angle or slide; path: of a point along a curve of a; touch: of a face of b along it; bearing
    ("body", int, 2),
    ("point", float, (2, 3)),  # m, body axes
    ("axis", float, (3, 3)),  # angle: x_a, y_a in a, x_b in b; bearing: x_a, y_a; slide: in a; touch: in b; body axes
    ("number", int),  # first of the numbers of the curve in Model.number: see surfaces.py
]
REFLECTED = [
    ("coordinate", int),  # hinge coordinate x of a joint; -1: it is a rate about an axis of b, of no angle
    ("body", int, 2),
    ("axis", float, 3),  # that axis, body axes of b
    ("inertia", float),  # kg m^2 or kg, I of the kinetic energy I x_dot^2 / 2
]
FORCE = [
    ("kind", int),  # number of its law
    ("body", int, 4),  # acting bodies a, b; up to four of a custom force
    ("bodies", int),  # their number
    ("point", float, (4, 3)),  # m, body axes
    ("frame", float, (2, 9)),  # axes of the element in a and b (columns), body axes
    ("signal", int, 3),  # signals of the components, -1 = none
    ("coordinate", int),  # hinge coordinate it acts along, -1 = none
    ("state", int),  # where the element's internal states start in z
    ("states", int),  # their number
    ("measure", int),  # first of the measures it reads
    ("measures", int),  # their number
    ("number", int),  # first of its parameters in Model.number: those its law declares by name, then series of numbers
    ("numbers", int),  # how many there are
    ("named", int),  # how many have a name
    ("option", int),  # choice that its law knows, as between world and body axes
    ("address", ADDRESS, 2),  # of a custom function, for real and for complex numbers; 0 = none
    ("row", int),  # first row of the joint whose reaction its law reads,
    ("rows", int),  # and their number, 0 = it reads none
]
SIGNAL = [("first", int), ("end", int)]  # its terms
TERM = [("kind", int), ("first", int), ("end", int)]  # its numbers in term_data: see signals.Term
MEASURE = [
    ("kind", int),
    ("body", int, 2),
    ("point", float, (2, 3)),  # m, body axes
    ("axis", float, 3),  # world axes, or body axes of the second body
    ("coordinate", int),
    ("state", int),  # place in z of the state it reads
    ("force", int),  # number of the contact or rope it speaks of, -1 = none
    ("row", int),  # first row of the joint whose reaction it is, or number of the section of a rope,
    ("rows", int),  # and number of rows
]
STATE = [("unit", float), ("power", float)]  # error of a state of z is measured against unit speed^power


@by_reference
class Model(NamedTuple):
    """Compiled mechanism with n bodies, p primitives, m rows; constant during a run."""

    body: np.ndarray  # (n,) BODY
    primitive: np.ndarray  # (p,) PRIMITIVE
    row: np.ndarray  # (m,) ROW
    coordinate: np.ndarray  # COORDINATE
    reflected: np.ndarray  # REFLECTED
    force: np.ndarray  # FORCE
    signal: np.ndarray  # SIGNAL
    term: np.ndarray  # TERM
    term_data: np.ndarray
    measure: np.ndarray  # MEASURE: those of the caller first, then those the forces read
    number: np.ndarray  # gains, references, parameters of forces; curves; polynomials of couplers
    state: np.ndarray  # STATE, layout of z: [states of force elements | work of forces | work of drivers | impulse (6)]
    gravity: np.ndarray  # (3,) m/s^2
    z_work: int
    z_drive: int
    z_impulse: int
    length: float  # m, the model's own length: scale of errors and of the rank decision
    singular: int  # 1: a body without mass or with a singular inertia
    frictions: int  # number of forces whose laws read multipliers
    gyroscopic: float  # 1, or 0 to drop w x I_G w
    centripetal: float  # 1, or 0 to drop m w x (w x s)
    gamma: float  # 1, or 0 to drop -J_dot v
    stabilisation: int  # NONE, BAUMGARTE, PROJECTION
    baumgarte_velocity: float  # a [1/s] and
    baumgarte_position: float  # b [1/s^2] of gamma -= a (J v - b) + b c


@cache
def data_records(dtype: type) -> dict[str, list]:
    """Return the record fields of the work space for real or complex numbers."""
    return {
        "body": [
            ("r", dtype, 3),  # m, reference point          } computed by kinematics
            ("e", dtype, 4),  # quaternion
            ("R", dtype, 9),  # body -> world
            ("s", dtype, 3),  # m, R r_G
            ("velocity", dtype, 3),  # m/s, of O
            ("w", dtype, 3),  # rad/s
            (
                "w_body",
                dtype,
                3,
            ),  # rad/s, body axes: straight from the state, so that Euler's term sees no R'R rounding
            ("Q", dtype, 6),  # applied force and moment about O, gravity included      } computed by loads
            ("h", dtype, 6),  # velocity-quadratic term
            ("spin", dtype, 3),  # N m, its gyroscopic part w x I_G w in body axes, free of R R' rounding
            ("top", dtype, 6),  # right side and work space of the upper rows           } saddle point
            ("turn", dtype, 3),  # N m, a further moment about G of the right side, body axes
            ("acceleration", dtype, 6),  # solution of the upper rows: (r_ddot, w_dot)
            ("alpha", dtype, 3),  # rad/s^2, R'w_dot
        ],
        "row": [
            ("lam", dtype),  # multiplier, zero in skipped rows } saddle point
            ("bottom", dtype),  # right side of the lower rows
            ("c", dtype),  # residual, m or rad               } computed by rows
            ("b", dtype),  # right side of J v = b
            ("gamma", dtype),  # right side of J v_dot = gamma
            ("J", dtype, (4, 6)),  # blocks per slot
        ],
        "force": [
            ("potential", dtype),  # J stored            } computed by loads
            ("power", dtype),  # W of the part that stores none
            ("x", dtype),  # the hinge coordinate it acts along, if any: value,
            ("rate", dtype),
            ("gradient", dtype, (4, 3)),  # rate = gradient . (velocity of a, w of a, velocity of b, w of b)
            ("load", dtype),  # N or N m along it: on b, the opposite on a
            ("shown", dtype, 12),  # where a load travels: its point [m], then what `ForceElement.shows` names
        ],
        "pose": [  # what a custom function sees of a point of a body, world axes
            ("r", dtype, 3),
            ("R", dtype, (3, 3)),
            ("velocity", dtype, 3),
            ("w", dtype, 3),
        ],
        "reflected": [
            ("J", dtype, (2, 6)),  # rate of the coordinate by the velocities of its bodies a and b,
            ("bias", dtype),  # and J_dot v: computed by rows
        ],
        "coordinate": [("value", float), ("rate", float)],  # at the last accepted state, to unwrap against: real
    }


@by_reference
class Data(NamedTuple):
    """Work space of one evaluation; real or complex."""

    body: np.ndarray  # (n + 1,)
    row: np.ndarray  # (m,)
    reflected: np.ndarray
    force: np.ndarray
    coordinate: np.ndarray
    unwrap_time: np.ndarray  # (1,) s, time of the last accepted state
    z: np.ndarray  # (z_work,) internal states of the force elements, computed by kinematics
    state_rate: np.ndarray  # (z_work,) their rates, computed by loads
    pose: np.ndarray  # (MOST_BODIES,) scratch of custom forces: what their function reads,
    wrench: np.ndarray  # (6 MOST_BODIES + 1,) the loads it fills, and 0 when it has returned
    scratch: np.ndarray  # (most numbers of a force,) what a law finds of each of its series, as of spans of a rope


@by_reference
class Tree(NamedTuple):
    """The saddle point over the rows in use: bodies from the leaves of a spanning tree to its roots, then loops.

    A *link* is a body with the rows that join it to its parent, as many as are independent; every other row in use is a
    *loop row*. An *entry* is a loop row that is felt by a link: on the link itself or through the links beyond it.
    """

    link: np.ndarray  # (n,) links; children stand before their parents
    joint: np.ndarray  # rows of the links, side by side
    loop: np.ndarray  # (l,) loop rows in elimination order
    entry: np.ndarray  # entries, those of a link side by side in ascending order of their loop rows
    compact: np.ndarray  # (n,) the links of a tree of hinges, slides and free bodies; none of any other mechanism,
    loose: np.ndarray  # and primitives that are none of its joints
    skyline: np.ndarray  # (2, size) lower triangles of S and of its factor L with 1 / L_ii: S_ij is [0, line_i + j]
    vector: np.ndarray  # (5, l) right side, then multipliers of loop rows; those of sweeps; residual, step; scratch
    shares: np.ndarray  # (48,) pivots by the power of two to which they have fallen
    state: np.record  # TREE_STATE
    used: np.ndarray  # rows in use, ascending
    skipped: np.ndarray  # rows left out


TREE_STATE = [
    ("mu", float),  # 1/kg of a row in radians and metres of the model: what keeps S regular where rows repeat others
    ("dense", int),  # 1: a pivot of a link has vanished (bodies without inertia): the dense matrix at this state
    ("apart", int),  # 1: a reflected inertia is on no link, so that bodies share inertia across loops: dense always
    ("graded", int),  # 1: pivots of the loop rows differ so much that S loses digits: solutions are refined
    ("weak", int),  # 1: some loop rows are nearly dependent on others
    ("soft", int),  # 1: some resist so little at the end of the last step that one sweep does not take mu away again
    ("rank", int),  # independent loop rows, the most at the end of any step: off c = 0 rows that repeat others seem so
    ("pivot", float),  # how far the least of these has fallen, as a share of its largest pivot so far
    ("idle", int),  # 1: some yielded nothing at the end of the last step, or never did: then the gap is asked for
    ("gap", float),  # largest |c| of the rows at the factorisation at hand, in the model's length or radians
    ("worn", int),  # 1: the rows of a link have become dependent on each other: the tree must be made anew
    ("compact", int),  # 1: state rates and projections by `Tree.compact`
]


@cache
def tree_records(dtype: type) -> dict[str, list]:
    """Return the record fields of the tree for real or complex numbers; 6-vectors are (linear, angular) about O."""
    return {
        "link": [
            ("body", int),
            ("up", int),  # link of the parent, -1 = the ground
            ("joint", int),  # first of its rows in Tree.joint
            ("rows", int),  # their number r
            ("entry", int),  # first of its entries
            ("entries", int),  # their number
            ("alone", int),  # 1: a free body that nothing touches
            ("lines", int),  # rows that come first since they do not only turn the body; -1: not to be told apart
            ("point", int),  # 1: the first three make two points coincide
            ("reflected", int),  # first reflected inertia of the joint to the parent,
            ("reflections", int),  # their number,
            ("side", int),  # and whether the body is a (0) or b (1) of their coordinates
            ("d", dtype, 3),  # m, from the parent's O to its own
            ("A", dtype, 9),  # articulated inertia [A B; B' C]: of the body and of all beyond it,
            ("B", dtype, 9),  # after the factorisation without what its own degrees of freedom take up
            ("C", dtype, 9),
            ("basis", dtype, (6, 6)),  # r directions that move one row each, then 6 - r that move none
            ("u", dtype, (6, 6)),  # inertia times each free direction; before that, scratch of `joint_basis`
            ("inverse", dtype, 6),  # of each pivot
            ("e", dtype, 6),  # acceleration along each free direction as far as the load gives it
            ("p", dtype, 6),  # load of the body and of all beyond it
            ("y", dtype, 6),  # acceleration that the rows prescribe
            ("a", dtype, 6),  # acceleration
        ],
        "joint": [
            ("row", int),
            ("slot", int),  # of the row that is on the body,
            ("twin", int),  # and a second one, -1 = none
        ],
        "loop": [
            ("row", int),
            ("end", int),  # one past its group: rows between the same bodies, of which the largest pivots come first
            ("first", int),  # first stored column of its line of S, the same for a group
            ("last", int),  # last line of S that has a column of its number
            ("line", int),  # start of the line
            ("mu", float),  # what is added to the diagonal
            ("at", int),  # the loop row that stands here in the factor
            ("pivot", float),  # here, in the factorisation at hand, times mu; 0 where nothing in the tree yields
            ("most", float),  # and the largest at the end of any step
            ("idle", int),  # 1: nothing in the tree yielded to this row at the end of the last step
        ],
        "entry": [
            ("place", int),  # of its loop row
            ("line", int),  # start of the line of that place
            ("next", int),  # the same loop row at the parent, -1 = it ends here
            ("slot", int),  # of the row on the body itself, -1 = none,
            ("twin", int),  # and a second one
            ("G", dtype, 6),  # loop row by the acceleration of the link
            ("e", dtype, 6),  # by that along each free direction
        ],
        "compact": [
            ("kind", int),  # COMPACT_HINGE ... of kinds.py
            ("body", int),
            ("up", int),  # link of the parent, -1 = the ground,
            ("parent", int),  # and its body
            ("on", int, 2),  # bodies a and b of the joint
            ("row", int),  # first of its rows, which follow each other
            ("leaf", int),  # 1: nothing is beyond it
            ("opens", int),  # 1: of the children of its parent it stands first
            ("reflected", int),  # first reflected inertia,
            ("reflections", int),  # their number,
            ("side", int),  # and which body of their coordinates the child is
            ("entry", int),  # first of its entries,
            ("entries", int),  # their number
            ("sign", float),  # 1: the child is body b of the joint; -1: body a
            ("point", float, (2, 3)),  # m, points of the joint on a and b, body axes
            ("axis", float, (3, 3)),  # x and y in a, z in b: it holds the turns x cross z and y cross z
            ("slide", float, (4, 3)),  # of a slide: x in a, y in b of its third turn, and normals of its line in a
            ("d", dtype, 3),  # m, from the parent's O to its own
            ("arm", dtype, 6),  # m, from the O of child and parent to the point of the joint
            ("t", dtype, 9),  # dual vectors of the turns that the joint holds
            ("n", dtype, 6),  # the motion that it leaves free
            ("u", dtype, 6),  # inertia times that
            ("inverse", dtype),  # of the pivot
            ("share", dtype),  # acceleration along n as far as the load gives it
            ("A", dtype, 6),  # articulated inertia, A and C symmetric: xx, xy, xz, yy, yz, zz,
            ("B", dtype, 9),  # after the factorisation without what n takes up;
            ("C", dtype, 6),  # of a free body the factors of it
            ("p", dtype, 6),  # load of the body and of all beyond it, then what the joint carries of it
            ("y", dtype, 6),  # acceleration that the rows prescribe
            ("a", dtype, 6),  # acceleration
        ],
    }


@cache
def record(fields: tuple) -> np.dtype:
    """Return the type of a record of fields, made once, since numpy takes longer for it than for a table."""
    return np.dtype(list(fields))


@cache
def with_attributes(fields: tuple) -> np.dtype:
    """Return the same type for records whose fields are attributes in Python."""
    return np.dtype((np.record, record(fields)))


TYPES: dict[int, tuple[list, np.dtype, np.dtype]] = {}
"""Of lists of fields, which live as long as the process, by their identity: to hash one takes longer than a table."""


def types_of(fields: list) -> tuple[list, np.dtype, np.dtype]:
    """Return a list of fields, the type of its records, and the same with attributes in Python."""
    found = TYPES.get(id(fields))
    if found is None:
        found = TYPES[id(fields)] = (fields, record(tuple(fields)), with_attributes(tuple(fields)))
    return found


def table(fields: list, count: int) -> np.ndarray:
    """Return a table of zero records; without the compiler its records have attributes in Python too."""
    array = np.zeros(count, types_of(fields)[1])
    return array.view(np.recarray) if numba.config.DISABLE_JIT else array


def single(fields: list) -> np.record:
    """Return one zero record, whose fields are attributes in kernels and in Python."""
    return np.zeros(1, types_of(fields)[2])[0]
