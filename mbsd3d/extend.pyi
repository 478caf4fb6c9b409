# checks of what a user gave; errors name the part, the value and the remedy
from .base.checks import number as number
from .base.checks import whole as whole
from .base.checks import solvable as solvable
from .base.checks import vector as vector
from .base.errors import Explained as Explained
from .base.errors import MbsError as MbsError
from .base.errors import explaining as explaining
from .base.errors import similar as similar
from .base.version import loading as loading
from .base.mass_properties import check_inertia as check_inertia
from .equations.at_state import check_quaternions as check_quaternions
from .equations.at_state import driven_coordinates as driven_coordinates
from .equations.at_state import load_state as load_state
from .equations.at_state import pack as pack
from .equations.at_state import unmet as unmet
from .equations.at_state import worst_joint as worst_joint
from .run.simulation import check_signals as check_signals
from .run.simulation import check_state as check_state
from .run.simulation import check_system as check_system
from .run.accelerations import Rates as Rates

# rotations and directions
from .base.directions import cross as cross
from .base.directions import matched_perpendiculars as matched_perpendiculars
from .base.directions import perpendiculars as perpendiculars
from .base.quaternions import H as H
from .base.quaternions import conjugate as conjugate
from .base.quaternions import exponential as exponential
from .base.quaternions import logarithm as logarithm
from .base.quaternions import multiply as multiply
from .base.quaternions import skew as skew
from .base.rotations import as_quaternion as as_quaternion
from .base.rotations import matrix as matrix
from .base.rotations import quaternion_from_matrix as quaternion_from_matrix

# files, progress, small dense algebra on one thread
from .base.paths import as_path as as_path
from .base.paths import package_version as package_version
from .base.paths import read_text as read_text
from .base.paths import with_suffix as with_suffix
from .base.paths import write_atomically as write_atomically
from .base.progress import Progress as Progress
from .base.concurrency import on_one_thread as on_one_thread
from .base.concurrency import one_thread as one_thread
from .sweeps.executors import closing as closing
from .sweeps.executors import outcomes as outcomes
from .sweeps.store import Store as Store

# figures and pages in the house style
from .base.style import DARK as DARK
from .base.style import LIGHT as LIGHT
from .base.style import LINE as LINE
from .base.style import RAISED as RAISED
from .base.style import THIN as THIN
from .base.style import Theme as Theme
from .base.style import aligned as aligned
from .base.style import dress as dress
from .base.style import house as house
from .base.style import new_figure as new_figure
from .base.style import theme as theme
from .base.templates import HtmlPage as HtmlPage
from .base.templates import page_template as page_template
from .report.exhibits import inline_svg as inline_svg
from .report.wording import digits as digits
from .view.scene.camera import VIEW_AXES as VIEW_AXES

# commands of the command line, demos, packages that load on first use
from .lazy import attach as attach
from .cli import main as main
from .cli.play import port_option as port_option
from .cli.support import INTERRUPTED as INTERRUPTED
from .cli.support import Failure as Failure
from .cli.support import can_view as can_view
from .cli.support import keep as keep
from .cli.support import load_system as load_system
from .cli.support import ready_folder as ready_folder
from .cli.support import watch as watch
from .demos.discovery import discover as discover
from .demos.form import Ablation as Ablation
from .demos.form import Against as Against
from .demos.form import Curve as Curve
from .demos.form import Demo as Demo
from .demos.form import Measured as Measured
from .demos.form import Quantity as Quantity
from .demos.form import require as require

# the mechanism as data: what joints lower to, what forces and signals are made of
from .kernels import kinds as kinds
from .mechanism import joints as joints
from .mechanism.couplings import Coupling as Coupling
from .mechanism.force_element import ForceElement as ForceElement
from .mechanism.force_element import hinge_coordinate as hinge_coordinate
from .mechanism.measures import Measure as Measure
from .mechanism.primitives import Coordinate as Coordinate
from .mechanism.primitives import Primitive as Primitive
from .mechanism.signals import as_signal as as_signal

# a model that is played: `play_model` takes a `Playable`
from .api.playing import Play as Play
from .api.playing import play_model as play_model
from .run.live_model import Built as Built
from .run.live_model import Control as Control
from .run.live_model import Panel as Panel
from .run.live_model import Playable as Playable
from .run.live_model import Seen as Seen
from .mechanism.signals.terms import POLYNOMIAL as POLYNOMIAL
from .mechanism.signals.terms import SINE as SINE
from .mechanism.signals.terms import evaluate as evaluate

# the equations at one state, plain and dense, and their derivatives
from .equations.compiled import compile_system as compile_system
from .equations.compiled import new_data as new_data
from .equations.dense_solvers import DenseEquations as DenseEquations
from .equations.dense_solvers import equations as equations
from .equations.dense_solvers import mass_matrix as mass_matrix
from .equations.dense_solvers import saddle_matrix as saddle_matrix
from .equations.tables import key_of as key_of
from .equations.tree import build_spanning_tree as build_spanning_tree
from .linear.variations import COMPLEX_STEP as COMPLEX_STEP
from .linear.variations import Field as Field
from .linear.variations import directions as directions
from .compiler.object_files import keep_code as keep_code
from .compiler.cache_folder import CACHE as CACHE
from .compiler.cache_folder import compiled_sources as compiled_sources
