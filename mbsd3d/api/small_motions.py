"""`linearize`: small motions about an equilibrium or a steady motion, as modes that can be plotted and animated."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, Unpack, overload

from ..base.checks import number
from ..base.errors import checks_arguments, checks_method_arguments
from ..equations.compiled import Switches
from ..linear import modes
from ..linear.linearization import linearize_at
from ..mechanism.measures import Measure
from ..mechanism.state import State
from .simulation import start_of
from .system import System
from .viewable import AnimateOptions, Viewable

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..view.page.html import View
    from ..view.page.live import LiveView


@dataclass(frozen=True, eq=False, repr=False)
class Motion(Viewable):
    """Poses of a mechanism over time (no forces, no energy): read like a `Solution`."""


@checks_method_arguments
@dataclass(frozen=True, eq=False, repr=False)
class Mode(modes.Mode):
    """One mode: ``X(t) = Re(shape exp(eigenvalue t))``.

    ``translation`` and ``rotation`` (n, 3) are complex displacements of the centres of mass [m] and rotations [rad] of
    all bodies, world axes, scaled such that the largest one, in model lengths or radians, is 1 and real.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Revolute, System
    >>> from mbsd3d import linearize
    >>> rod = Body("rod", mass=2.0, inertia=(0.06, 0.06, 0.001), position=(0, 0, -0.3))
    >>> swing = linearize(System([rod], [Revolute(GROUND, rod, at=(0, 0, 0), axis=(0, 1, 0))])).mode(0)
    >>> round(swing.frequency, 9), abs(round(swing.damping_ratio, 9))
    (0.788178601, 0.0)
    >>> swing.motion(amplitude=0.1, samples=5).position("rod").shape  # .animate() shows it
    (5, 3)
    """

    def motion(self, amplitude: float = 0.2, cycles: float = 2.0, samples: int = 101) -> Motion:
        moved = super().motion(amplitude, cycles, samples)
        return Motion(moved.compiled, moved.arrays)

    motion.__doc__ = modes.Mode.motion.__doc__

    @overload
    def animate(
        self, amplitude: float = 0.2, cycles: float = 2.0, *, live: Literal[False] = False,
        **options: Unpack[AnimateOptions],
    ) -> "View": ...  # fmt: skip
    @overload
    def animate(
        self, amplitude: float = 0.2, cycles: float = 2.0, *, live: Literal[True], **options: Unpack[AnimateOptions]
    ) -> "LiveView": ...
    def animate(self, amplitude: float = 0.2, cycles: float = 2.0, **options: Any) -> "View | LiveView":
        """Return a page that shows `motion`; options as in `Solution.animate`; a period takes 2 s without ``speed``."""
        cycles = number(cycles, "animate: cycles", positive=True)
        moved = self.motion(amplitude, cycles, samples=int(50 * max(cycles, 1.0)) + 1)
        seconds, title = 2.0 * cycles, f"{self.label}, {self.frequency:.4g} Hz"
        return moved.animate(**{"speed": float(moved.t[-1]) / seconds, "title": title, **options})


@checks_method_arguments
@dataclass(frozen=True, eq=False, repr=False)
class Linearization(modes.ModalAnalysis):
    """``x_dot = A x`` for small deviations from a motion; parts are given as objects or by name.

    Attributes
    ----------
    A : (n, n) array
        In SI units; of the states x, or of the outputs y if any were asked for.
    states, state_units : tuple of str
        What each x (or y) is: "x of frame" is the displacement of the centre of mass, "theta_x of frame" the rotation,
        "v_x" and "w_x" the changes of velocity and angular velocity; world axes, turning with the mechanism if that
        turns as a whole. All other displacements follow from the constraints.
    eigenvalues : (n,) complex array
        [1/s] by frequency, then real part. Zeros are exact: see `mbsd3d.linear.linearization.spectrum`.
    modes : tuple of Mode
        One per real eigenvalue and per complex pair.
    generator : Generator
        The steady motion that was found.
    residual : float
        Largest violation of the assumptions, in the model's units of length and time.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Revolute, System, linearize
    >>> rod = Body("rod", mass=2.0, inertia=(0.06, 0.06, 0.001), position=(0, 0, -0.3))
    >>> found = linearize(System([rod], [Revolute(GROUND, rod, at=(0, 0, 0), axis=(0, 1, 0))]))
    >>> found.eigenvalues.imag.round(6), found.generator.turning  # sqrt(m g l / (I + m l^2))
    (array([ 4.952272, -4.952272]), False)
    """

    @cached_property
    def modes(self) -> tuple[Mode, ...]:
        """Return one mode per real eigenvalue and per complex pair, in the order of the eigenvalues."""
        return tuple(
            Mode(self, mode.eigenvalue, mode.translation, mode.rotation, mode.vector) for mode in modes.make_modes(self)
        )

    def plot(self) -> "Figure":
        """Draw the eigenvalues in the complex plane with matplotlib."""
        from ..plotting.panels import plot_eigenvalues

        return plot_eigenvalues(self)


@checks_arguments
def linearize(
    system: System,
    state: State | None = None,
    *,
    outputs: Sequence[Measure] | None = None,
    tolerance: float = 1e-8,
    gyroscopic: bool = True,
    centripetal: bool = True,
    gamma: bool = True,
) -> Linearization:
    """Return the linear equations of small motions about an equilibrium or a relative equilibrium.

    States x are displacements on the constraint manifold (J of the holonomic rows), velocities that meet
    ``J delta v + d(J v - b)/dq delta q = 0`` (all rows, nonholonomic ones too), and internal states of force elements,
    all in world axes. About a steady motion that turns as a whole (precession of a top, a turn of a vehicle) they are
    carried along: ``x_dot = A x`` with the generator of the turn subtracted. A is exact to rounding: derivatives are
    complex steps, the row set is frozen.

    Parameters
    ----------
    system : System
    state : State or None
        An equilibrium or a steady motion; None = ``system.state()``.
    outputs : sequence of Measure or None
        y = L x whose rates depend on y alone: A is then the unique A_y with ``L A = A_y L``. Divides cyclic coordinates
        out, which otherwise leave zeros with Jordan blocks.
    tolerance : float
        Largest residual of the conditions of a steady motion, in units of the model's length and its fastest rate.
    gyroscopic, centripetal, gamma : bool
        Teaching switches as in `simulate`: False drops w x I w, m w x (w x s), -J_dot v.

    Returns
    -------
    Linearization
        Printed: a table of the modes; ``.plot()`` draws the eigenvalues, ``.mode(k).animate()`` moves the mechanism.

    Notes
    -----
    Straight motion at constant speed is steady in world axes, also with wheels that spin, if they are symmetric about
    their axes. A turn needs axes that turn along: there a displacement of everything, which stands still in the world,
    shows as a pair of eigenvalues +-i Omega. A body that drifts through space while it turns is not covered, nor are
    independent mechanisms that move at different speeds.

    Raises
    ------
    ValueError
        If the state is no (relative) equilibrium, the equations change along the motion (an unbalanced wheel), a
        signal varies with time, the position is singular, nothing can move, or the outputs do not close; each with
        the part and the residual.
    AssemblyError
        If the state does not meet a joint.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Revolute, System
    >>> from mbsd3d import linearize
    >>> rod = Body("rod", mass=2.0, inertia=(0.06, 0.06, 0.001), position=(0, 0, -0.3))
    >>> hinge = Revolute(GROUND, rod, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")
    >>> swing = linearize(System([rod], [hinge])).mode(0)  # sqrt(m g l / (I + m l^2))
    >>> round(swing.eigenvalue.imag, 9), swing.label
    (4.952272206, "angle of 'hinge'")
    """
    start = start_of(system, state, "linearize")
    switches = Switches(gyroscopic, centripetal, gamma)
    return Linearization.of(linearize_at(system, start, outputs=outputs, tolerance=tolerance, switches=switches))
