"""`linearize`: small motions about an equilibrium or a steady motion, as modes that can be plotted and animated."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, Unpack, overload

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import number, short_repr
from ..base.errors import InputError, checks_arguments, checks_method_arguments
from ..base.fields import as_public
from ..equations.compiled import Switches
from ..linear import campbell as diagrams
from ..linear import modes
from ..linear import state_space as models
from ..linear.inputs_outputs import Wanted
from ..linear.linearization import linearize_at
from ..mechanism.bodies import Body
from ..mechanism.joints import Joint
from ..mechanism.measures import Measure
from ..mechanism.mechanism import Mechanism
from ..mechanism.signals.signal import Input
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

    States x are displacements on the constraint manifold (J of the holonomic rows), velocities that satisfy ``J delta v
    + d(J v - b)/dq delta q = 0`` (all rows, including nonholonomic ones), and internal states of force elements, all in
    world axes. About a steady motion that rotates as a whole (precession of a top, a vehicle in a curve) the axes
    rotate with it: ``x_dot = A x`` with the generator of the rotation subtracted. A is exact to rounding: derivatives
    are complex steps, and the set of rows is fixed.

    Parameters
    ----------
    system : System
    state : State or None
        An equilibrium or a steady motion; None = ``system.state()``.
    outputs : sequence of Measure or None
        y = L x whose rates depend on y alone: A is then the unique A_y with ``L A = A_y L``. This eliminates cyclic
        coordinates, which otherwise give zero eigenvalues with Jordan blocks.
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
    Straight motion at constant speed is steady in world axes, also with spinning wheels, if they are symmetric about
    their axes. A curve needs axes that rotate with the motion: in these, a displacement of the whole system, which is
    constant in the world, appears as a pair of eigenvalues +-i Omega. Bodies that drift through space while they rotate
    are not covered, nor are independent mechanisms that move at different speeds.

    Raises
    ------
    ValueError
        If the state is not a (relative) equilibrium, the equations change along the motion (an unbalanced wheel), a
        signal varies with time, the position is singular, nothing can move, or the outputs do not close; each with the
        part and the residual.
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


@checks_method_arguments
@dataclass(frozen=True, eq=False, repr=False)
class FrequencyResponse(models.FrequencyResponse):
    """Frequency response ``H[frequency, output, input]`` of a `StateSpace`, complex.

    ``H = A exp(i phase)``: an input cos(w t) is followed by the output A cos(w t + phase).

    Attributes
    ----------
    w : (n,) array
        Frequencies [rad/s].
    H : (n, outputs, inputs) complex array
        Output units per input unit; infinite at a pole on the imaginary axis that appears in the entry.
    at_poles : tuple of (float, str)
        These frequencies [rad/s], and which mode has the pole.

    Examples
    --------
    >>> from mbsd3d import Body, Force, Input, System, measures, state_space
    >>> stone = Body("stone", 2.0, (1, 1, 1))
    >>> push = Force(stone, (Input("push"), 0, 0))
    >>> place = measures.position(stone, axis=(1, 0, 0))
    >>> free = state_space(System([stone], forces=[push], gravity=(0, 0, 0)), outputs=[place])
    >>> print(free.frequency_response([0.0]))
    <frequency response: 1 output, 1 input, 1 frequency 0 ... 0 rad/s>
    infinite at 0 rad/s, a pole: x of 'stone'
    """

    def plot(self, *, dark: bool = False) -> "Figure":
        """Draw magnitude and phase over the frequency with matplotlib: a column per input, a line per output."""
        from ..plotting.frequencies import plot_bode

        return plot_bode(self, dark=dark)


@checks_method_arguments
@dataclass(frozen=True, eq=False, repr=False)
class StateSpace(models.StateSpace):
    """Linear model of small motions between input signals u and outputs y, as deviations from a steady motion.

    ``z' = A z + B u``, ``y = C z + D u + D1 u' + D2 u''``. D1 and D2 are zero, and z are the states x of
    `Linearization`, unless inputs prescribe motions. Then ``z = x - B2 u' - (B1 + A B2) u`` with
    ``x' = A x + B0 u + B1 u' + B2 u''``, so that no rates of u act on z. States are not unique: compare H, D and poles.

    Attributes
    ----------
    A, B, C, D, D1, D2 : arrays
        In SI units.
    states, inputs, outputs : tuple of str
    state_units, input_units, output_units : tuple of str
        "-" for internal states of forces, and for inputs that set different quantities or a multiple of one.
    poles : (n,) complex array
        Eigenvalues of A [1/s].
    zeros : complex array
        Invariant zeros [1/s] of a model with as many outputs as inputs, see `select`.
    linearization : ModalAnalysis
        The linearisation with its modes.

    Examples
    --------
    >>> from mbsd3d import Body, Force, Prismatic, System, measures, state_space
    >>> from mbsd3d import GROUND, Input, SpringDamper
    >>> cart = Body("cart", 2.0, (1, 1, 1))
    >>> rail = Prismatic(GROUND, cart, at=(0, 0, 0), axis=(1, 0, 0))
    >>> spring = SpringDamper(GROUND, cart, at_a=(-1, 0, 0), at_b=(0, 0, 0), stiffness=50.0, damping=4.0)
    >>> pushed = System([cart], [rail], [spring, Force(cart, (Input("push"), 0, 0))])
    >>> model = state_space(pushed, outputs=[measures.slide(rail), ("acceleration", cart)])
    >>> model.poles.round(6)
    array([-1.+4.898979j, -1.-4.898979j])
    >>> model.D[1].round(9), model.frequency_response([0.0]).H[0, 0].round(9)  # 1 / m, 1 / k
    (array([0.5]), array([0.02+0.j]))
    """

    def frequency_response(self, w: ArrayLike) -> FrequencyResponse:
        return as_public(FrequencyResponse, super().frequency_response(w))

    frequency_response.__doc__ = models.StateSpace.frequency_response.__doc__

    def bode(self, w: ArrayLike | None = None, *, dark: bool = False) -> "Figure":
        """Draw magnitude and phase over w [rad/s] with matplotlib: a column per input, a line per output.

        ``w`` None = from a tenth of the slowest pole beside zero to ten times the fastest.
        """
        return self.frequency_response(models.usual_frequencies(self.poles) if w is None else w).plot(dark=dark)


@checks_arguments
def state_space(
    system: System,
    state: State | None = None,
    *,
    outputs: Sequence[Wanted],
    inputs: Sequence[Input | str] | None = None,
    driver: str = "position",
    tolerance: float = 1e-8,
) -> StateSpace:
    """Return the linear model from inputs to outputs about an equilibrium or a steady motion.

    Steady motions, nonholonomic and redundant rows as in `linearize`. Derivatives are complex steps and solutions of
    the linear equations of the accelerations, exact to rounding; those of a force by its own input are central
    differences of order 8, exact to rounding if the force is linear in the input, to about 1e-13 otherwise, as for
    wind.

    Parameters
    ----------
    system : System
        With `mbsd3d.Input` in forces, torques, laws or drivers; their values are those of the steady motion.
    state : State or None
        An equilibrium or a steady motion; None = ``system.state()``.
    outputs : sequence
        Of `mbsd3d.measures`; ``("derivative", measure)``, its rate of change; ``("acceleration", body)`` of the
        reference point [m/s^2] and ``("alpha", body)`` [rad/s^2], three components each; ``("reaction", joint)``, force
        [N] and moment [N m] on body b at the joint's point (where that travels, the force alone);
        ``("effort", driver)``; ``("force", element)``, force and moment of a force element on its last body but the
        ground, as of a reaction. Vectors are in world axes, turning with the mechanism if that turns as a whole.
    inputs : sequence of Input or str, or None
        The inputs u in their order; None = all of the system.
    driver : "position" or "acceleration"
        The input where a driver prescribes a motion: the motion u itself, so that outputs may depend on u' and u''; or
        u'', with u and u' as further states (for a speed: u', with u as a state), which always gives a proper model.
    tolerance : float
        As in `linearize`.

    Returns
    -------
    StateSpace
        With ``.frequency_response(w)``, ``.poles``, ``.zeros``, ``.bode()``, ``.step(t)``, ``.to_scipy()``,
        ``.to_control()``.

    Raises
    ------
    ValueError
        As `linearize`; for an input that is not in the system, acts in another way at another time of the motion, or
        prescribes what joints hold; for an output that changes along the motion, and for reactions that redundant
        joints leave undetermined.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Prismatic, Revolute, SlideDriver, System, measures
    >>> from mbsd3d import Input, state_space
    >>> cart, bob = Body("cart", 1.0, (1, 1, 1)), Body("bob", 2.0, (0.1, 0.1, 0.1), position=(0, 0, -0.5))
    >>> rail = Prismatic(GROUND, cart, at=(0, 0, 0), axis=(1, 0, 0))
    >>> pin = Revolute(cart, bob, at=(0, 0, 0), axis=(0, 1, 0))
    >>> moved = System([cart, bob], [rail, pin, SlideDriver(rail, Input("shift"), name="motor")])
    >>> model = state_space(moved, outputs=[measures.angle(pin), ("effort", "motor")])
    >>> model.D.round(6).tolist(), model.D2.round(6).tolist()  # m l / (I + m l^2); M + m - (m l)^2 / (I + m l^2)
    ([[1.666667], [27.25]], [[0.0], [1.333333]])
    """
    start = start_of(system, state, "state_space")
    found = models.state_space_at(system, start, inputs, outputs, driver=driver, tolerance=tolerance)
    return as_public(StateSpace, found)


@checks_method_arguments
@dataclass(frozen=True, eq=False, repr=False)
class Campbell(diagrams.Campbell):
    """Whirl frequencies of a rotor over its speed; printed: a table of modes and critical speeds.

    Attributes
    ----------
    speeds : (n,) array
        [rad/s]
    frequencies : (n, k) array
        Whirl frequencies [rad/s], a column per mode, followed by its shape; NaN where it does not oscillate.
    eigenvalues : (n, k) complex array
        [1/s]; a positive real part is an unstable whirl.
    sense : (n, k) array
        Signed area of the orbit over that of a circle: 1 forward, with the spin, 0 a line, -1 backward.
    whirl, labels : tuple of str
        "forward", "backward", "planar" or "mixed" of each mode, and what moves in it.

    Examples
    --------
    >>> import numpy as np
    >>> from mbsd3d import GROUND, Body, Bushing, System, campbell, measures
    >>> disc = Body("disc", 20.0, (0.4, 0.4, 0.6))  # I_p > I_t: the forward conical whirl is never critical
    >>> ends = [Bushing(GROUND, disc, at=(0, 0, z), stiffness=(1e6, 1e6, 1e3)) for z in (-0.25, 0.25)]
    >>> rotor = System([disc], forces=ends, gravity=(0, 0, 0))
    >>> found = campbell(rotor, spin=measures.omega(disc, axis=(0, 0, 1)), speeds=np.linspace(0.0, 600.0, 13))
    >>> [(round(x.speed, 3), x.whirl) for x in found.critical_speeds() if x.whirl != "planar"]
    [(316.228, 'backward'), (316.228, 'forward'), (353.553, 'backward')]
    """

    def plot(self, *, dark: bool = False) -> "Figure":
        """Draw the whirl frequencies over the speed with matplotlib, with the critical speeds."""
        from ..plotting.frequencies import plot_campbell

        return plot_campbell(self, dark=dark)


@checks_arguments
def campbell(system: System, *, spin: Joint | Measure, speeds: ArrayLike, state: State | None = None) -> Campbell:
    """Return the Campbell diagram: whirl frequencies of a rotor over its speed, sense of the orbits, critical speeds.

    At each speed the system is linearised about the steady rotation. Modes are tracked by their shape, from the last
    speed, where forward and backward ones are farthest apart, to the first.

    Parameters
    ----------
    system : System
        Its rotors must be symmetric about their axes; otherwise the equations change as they turn, and are refused.
    spin : Joint or Measure
        The hinge that rotates at the speed, or `measures.omega` of a rotor that is held by bushings and no joint. Body
        a of the hinge is at rest, such as a pedestal on springs; body b is the rotor. An AngleDriver or a SpeedDriver
        on the hinge turns it at each of the speeds, whatever its signal.
    speeds : (n,) array_like
        Two or more, ascending [rad/s]; a critical speed between two of them is found to rounding.
    state : State or None
        A pose at rest in which the rotor is in equilibrium; None = that of the system.

    Returns
    -------
    Campbell
        ``.critical_speeds(order)``: where a whirl frequency is ``order`` times the speed. ``.plot()`` draws it.

    Raises
    ------
    ValueError
        As `linearize`; for a ``spin`` that is neither hinge nor angular velocity, and speeds that do not ascend.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Bushing, System, campbell, measures
    >>> disc = Body("disc", 10.0, (0.1, 0.1, 0.15))
    >>> shaft = Bushing(GROUND, disc, at=(0, 0, 0), stiffness=(4e4, 4e4, 1e6))
    >>> rotor = System([disc], forces=[shaft], gravity=(0, 0, 0))
    >>> spin = measures.omega(disc, axis=(0, 0, 1))
    >>> found = campbell(rotor, spin=spin, speeds=[0.0, 50.0, 100.0])
    >>> [round(x.speed, 6) for x in found.critical_speeds() if x.whirl == "forward"]  # sqrt(k / m)
    [63.245553]
    """
    rest = start_of(system, state, "campbell")
    if isinstance(spin, Measure) and spin.kind == "omega" and isinstance(spin.b, Body):
        axis, rotor = spin.axis, spin.b

        def at(speed: float) -> tuple[Mechanism, State]:
            return system, diagrams.spinning_state(system, rest, rotor, axis, speed)
    elif isinstance(spin, Joint):
        pose = replace(system.assemble(near=rest), v=np.zeros(rest.v.size))
        axis, hinge = diagrams.axis_of(system, pose, spin), spin

        def at(speed: float) -> tuple[Mechanism, State]:
            driven = diagrams.driven_at(system, hinge, speed, pose.t)
            return driven, diagrams.turning_state(driven, pose, hinge, speed)
    else:
        raise InputError(f"campbell: spin: {short_repr(spin)}; give a hinge, or measures.omega(rotor, axis=...)")
    return as_public(Campbell, diagrams.campbell_of(at, axis, speeds))
