# the equations at one state, plain and dense
from ..equations.dense_solvers import equations as equations
from ..equations.dense_solvers import DenseEquations as DenseEquations
from ..equations.dense_solvers import mass_matrix as mass_matrix
from ..equations.dense_solvers import saddle_matrix as saddle_matrix
from ..run.accelerations import Rates as Rates
from ..dynamics.applied_forces import loads as loads

# states
from ..equations.at_state import load_state as load_state
from ..equations.at_state import pack as pack
from ..equations.at_state import driven_coordinates as driven_coordinates
from ..equations.at_state import unmet as unmet
from ..equations.at_state import worst_joint as worst_joint

# compiled tables, derivatives and code
from ..equations.compiled import Switches as Switches
from ..equations.compiled import compile_system as compile_system
from ..equations.compiled import new_data as new_data
from ..equations.tables import key_of as key_of
from ..equations.tree import build_spanning_tree as build_spanning_tree
from ..kernels.layout import Tree as Tree
from ..linear.variations import Field as Field
from ..linear.variations import COMPLEX_STEP as COMPLEX_STEP
from ..linear.variations import directions as directions
from ..compiler.object_files import keep_code as keep_code
from ..compiler.cache_folder import CACHE_FOLDER as CACHE_FOLDER
from ..compiler.cache_folder import compiled_sources as compiled_sources

# rows, coordinates, forces and signals
from ..kernels import kinds as kinds
from ..mechanism.primitives import Primitive as Primitive
from ..mechanism.primitives import Coordinate as Coordinate
from ..mechanism.bodies import Ground as Ground
from ..mechanism.couplings import Coupling as Coupling
from ..mechanism.force_element import ForceElement as ForceElement
from ..mechanism.force_element import hinge_coordinate as hinge_coordinate
from ..mechanism.measures import Measure as Measure
from ..mechanism.joints import angle_of as angle_of
from ..mechanism.joints import slide_of as slide_of
from ..mechanism.signals import as_signal as as_signal
from ..mechanism.signals.terms import evaluate as evaluate

# rotations and directions
from ..base.rotations import matrix as matrix
from ..base.rotations import as_quaternion as as_quaternion
from ..base.rotations import quaternion_from_matrix as quaternion_from_matrix
from ..base.rotations import H as H
from ..base.rotations import conjugate as conjugate
from ..base.rotations import exponential as exponential
from ..base.rotations import logarithm as logarithm
from ..base.rotations import multiply as multiply
from ..base.rotations import skew as skew
from ..base.rotations import cross as cross
from ..base.rotations import perpendiculars as perpendiculars
from ..base.rotations import matched_perpendiculars as matched_perpendiculars
