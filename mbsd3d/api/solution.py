"""The public `Solution`: the result of a run, with plots, reports, pages and files."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from inspect import Parameter, Signature
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.checks import number
from ..base.errors import InputError, IntegrationError, argument_error, checks_method_arguments
from ..base.fields import as_public
from ..base.style import html_text
from ..base.wording import counted
from ..equations.compiled import Switches
from ..integrators.dop853 import DOP853
from ..mechanism.bodies import Body, Ground
from ..mechanism.force_element import ForceElement
from ..mechanism.joints import Joint
from ..mechanism.measures import Measure
from ..mechanism.state import State
from ..results.certificate import Certificate, certificate_of
from ..results.element_loads import Load, load_of
from ..results.record import RunOptions
from ..results.result import RunResult
from ..results.spectrum import density_of, orders_of, spectrum_of, waterfall_of
from ..run.global_error import estimate
from ..run.repeat import options_to_repeat, repeat
from ..run.simulation import RUN_SHARE_MIN
from .spectra import Density, Spectrum, Waterfall
from .viewable import Viewable

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from pandas import DataFrame
    from xarray import Dataset

    from ..plotting.panels import Part, PlotQuantity, Wanted
    from ..report.page import Report


SWITCH_NAMES = tuple(x.name for x in fields(Switches))
OPTION_NAMES = tuple(x.name for x in fields(RunOptions) if x.name != "switches")
GIVEN = tuple(x.name for x in fields(RunResult) if x.init)
CHANGEABLE_ARGUMENTS = Signature(
    [Parameter(name, Parameter.KEYWORD_ONLY, default=None) for name in ("t_end", "state", *OPTION_NAMES, *SWITCH_NAMES)]
)
"""Arguments of `simulate` that `Solution.again` takes."""


@checks_method_arguments
@dataclass(frozen=True, eq=False, repr=False)
class Solution(RunResult, Viewable):
    """Samples of a run. Parts are given as objects or by name; vectors are (samples, 3) in world axes.

    ``events`` are those of parts that switch during the run: each has ``t`` [s], ``what``, the energy ``lost`` [J], the
    ``work`` of drivers [J], ``impulses`` by part, and ``rest`` [s] where bounces ended.

    Examples
    --------
    >>> from mbsd3d import Body, System, simulate
    >>> stone = Body("stone", 1.0, (0.1, 0.1, 0.1), velocity=(0, 0, 3.0), omega=(0, 0, 0))
    >>> flight = simulate(System([stone]), 1.0, output=[0.25, 1.0])
    >>> flight.position("stone")[:, 2].round(9)  # v t - g t^2 / 2
    array([ 0.4434375, -1.905    ])
    >>> flight.energy().total.round(9)
    array([4.5, 4.5])
    """

    def __repr__(self) -> str:
        span = f"{self.t[0]:g} ... {self.t[-1]:g} s" if self.t.size else "nothing"
        name = f" of {self.system.title!r}" if self.system.title else ""
        size = counted(self.t.size, "sample")
        return f"<solution{name}: {size}, {span}, by {self.record.method}; print(solution.certificate)>"

    def _repr_html_(self) -> str:
        return html_text(f"{repr(self).strip('<>').partition('; print')[0]}\n{self.certificate}")

    @classmethod
    def of(cls, result: RunResult) -> "Solution":
        """Return the solution of a result: the same numbers."""
        return cls(**{name: getattr(result, name) for name in GIVEN})

    @property
    def certificate(self) -> Certificate:
        """Return the certificate: which checks the samples pass, and how far they can be trusted."""
        return certificate_of(self)

    def force(self, force: ForceElement | str, on: Body | Ground | str | None = None) -> Load:
        """Force [N] and moment [N m] of a force element on a body at its point, with power, stretch and internal
        states.

        ``on`` None = body b of two, the last one of a `CustomForce`. ValueError for a body on which it does not act,
        and if the function of a `CustomForce` was not saved.
        """
        return load_of(self, force, on)

    def at(self, t: float) -> State:
        """Return the state at any time of the run [s], by integrating on from the sample before it."""
        t = number(t, "solution.at: t")
        begin = self.start.t
        if not begin <= t <= self.final.t:
            raise InputError(f"solution.at: t = {t:g} s is outside the run {begin:g} ... {self.final.t:g} s")
        k = int(np.searchsorted(self.t, t, side="right")) - 1
        start = self.state(k) if k >= 0 else self.start
        same = t - start.t <= RUN_SHARE_MIN * abs(t)  # too short for any run
        return start if same else self.again(t, state=start, output=[t]).final

    def again(self, t_end: float | None = None, **changes: Any) -> "Solution":
        """Run the same system again with the same options, except for the given ones (see `simulate`)."""
        if wrong := argument_error("Solution.again", CHANGEABLE_ARGUMENTS, (), changes):
            raise wrong
        start = changes.pop("state", self.start)
        options = changed(options_to_repeat(self), changes)
        if start is None:
            system: Any = self.system  # the public one, whose start may be its own
            start = system.state(as_built=options.as_built)
        try:
            return Solution.of(repeat(self, t_end, start, options))
        except IntegrationError as error:
            publish_solution(error)
            raise

    def plot(
        self,
        quantity: "str | Wanted | None" = None,
        *parts: "Part",
        against: "PlotQuantity | None" = None,
        degrees: bool = False,
        dark: bool = False,
        axes: "Axes | Sequence[Axes] | None" = None,
    ) -> "Figure":
        """Draw a quantity over time, or over another one.

        Parameters
        ----------
        quantity : str, sequence of str and (str, part, ...), or None
            "energy", "momentum", "drift"; of bodies "position", "orientation", "velocity", "omega", "omega_body",
            "acceleration", "alpha", "com"; of joints "angle", "slide", "rate", "reaction"; of drivers "effort"; of
            forces "state" (internal states); of parts that switch at events "engaged" (1, else 0). Several, e.g.
            ``["energy", ("angle", hinge)]``, are drawn one below the other; None = the default ones, as on a page:
            coordinates that move, energies, efforts of drivers, reactions, engaged parts.
        *parts : Body, Joint, ForceElement or str
            Parts that have it; none = all of them. Components of one part share a panel; several parts are compared
            component by component (reactions: by magnitude).
        against : str, measure or (str, part), optional
            Quantity on the horizontal axis instead of time, e.g. ``plot("rate", hinge, against="angle")``; a name alone
            applies to the same parts. The start is marked.
        degrees : bool
            Angles in degrees instead of radians.
        dark : bool
            On dark paper.
        axes : matplotlib Axes, sequence of them, or None
            Where to draw, one per panel; None = a new figure.

        Returns
        -------
        matplotlib.figure.Figure
            Not shown; a notebook shows it when it is the last value of a cell, `save_figure` writes it.

        Raises
        ------
        ValueError
            For an unknown quantity or part, a part without the quantity, or a wrong number of axes.

        Examples
        --------
        >>> from mbsd3d import Body, System, simulate
        >>> top = Body("top", 1.0, (1.0, 2.0, 3.0), omega=(0.01, 5.0, 0.0), velocity=(0, 0, 0))
        >>> figure = simulate(System([top], gravity=(0, 0, 0)), 2.0).plot("omega_body", degrees=True)
        >>> figure.axes[0].get_ylabel()
        'angular velocity, body axes of\\ntop [°/s]'
        """
        from ..plotting.plots import plot_quantity

        return plot_quantity(self, quantity, *parts, against=against, degrees=degrees, dark=dark, axes=axes)

    def spectrum(
        self, quantity: str | Measure, part: "Part | None" = None, *, window: str = "none", after: float | None = None
    ) -> Spectrum:
        """Return the amplitudes of a quantity over frequency.

        Parameters
        ----------
        quantity : str or Measure
            A measure; or of bodies "position", "velocity", "omega", "acceleration", "alpha", "com" ...; of joints
            "angle", "slide", "rate", "reaction" (force) and "reaction_moment"; of drivers "effort"; of forces "force"
            and "force_moment", on body b.
        part : Body, Joint, ForceElement or str
            Whose; None for a measure.
        window : "none", "hann" or "flat top"
            "none" is exact over whole periods. Windows are divided by their mean: a tone on a bin keeps its level; half
            a bin off, "hann" shows 0.849 of it, "none" 0.637, "flat top" 0.999.
        after : float or None
            Samples before this time [s] are left out, e.g. until a transient has decayed.

        Returns
        -------
        Spectrum
            Peak amplitudes c = A exp(i phase) of A cos(w t + phase); ``.at(hertz)``, ``.levels()``, ``.plot()``.

        Raises
        ------
        ValueError
            For samples that are not evenly spaced (run with ``output=`` a number), an unknown quantity or part, and
            reactions that redundant joints leave open.

        Examples
        --------
        >>> from mbsd3d import Body, Force, Sine, System, simulate
        >>> block = Body("block", 2.0, (1, 1, 1), velocity=(0, 0, 0), omega=(0, 0, 0))
        >>> shaken = System([block], forces=[Force(block, (Sine(6.0, 5.0), 0, 0))], gravity=(0, 0, 0))
        >>> seen = simulate(shaken, 1.0, output=101).spectrum("acceleration", block)
        >>> seen.at(5.0).round(6), seen.unit  # 3 sin(w t) = 3 cos(w t - pi / 2)
        (array([-0.-3.j,  0.+0.j,  0.+0.j]), 'm/s^2')
        """
        return as_public(Spectrum, spectrum_of(self, quantity, part, window, after))

    def density(
        self, quantity: str | Measure, part: "Part | None" = None, *, segments: int = 8, after: float | None = None
    ) -> Density:
        """Return the power spectral density of a quantity by Welch's method: half overlapping segments, Hann window.

        Parameters
        ----------
        quantity, part, after
            As in `spectrum`.
        segments : int
            Number of segment lengths in the record: more of them reduce scatter and resolution.

        Returns
        -------
        Density
            One-sided, in units squared per Hz.
        """
        return as_public(Density, density_of(self, quantity, part, segments, after))

    def orders(
        self,
        hinge: Joint | str,
        quantity: str | Measure,
        part: "Part | None" = None,
        *,
        per_turn: int = 128,
        after: float | None = None,
    ) -> Spectrum:
        """Return the amplitudes of a quantity over orders of a hinge, also where its speed varies.

        The run is repeated with samples at equal angles of the hinge, which are hit to 1e-9 rad, over all whole turns.

        Parameters
        ----------
        hinge : Joint or str
            Order 1 is its turn.
        quantity, part, after
            As in `spectrum`.
        per_turn : int
            Samples per turn; orders up to half as many are resolved.

        Returns
        -------
        Spectrum
            c = A exp(i phase) of A cos(order angle + phase), the angle counted in the sense of the turning.

        Raises
        ------
        ValueError
            If the hinge turns back, or less than once, or as in `spectrum`.

        Examples
        --------
        >>> from mbsd3d import GROUND, AngleDriver, Body, Kinematic, Ramp, Revolute, System, simulate
        >>> arm = Body("arm", 2.0, (0.1, 0.1, 0.1), com=(0.25, 0, 0))
        >>> hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")
        >>> system = System([arm], [hinge, AngleDriver(hinge, Ramp(3.0), name="motor")])
        >>> run = simulate(system, 2.5, method=Kinematic(), output=50)
        >>> run.orders(hinge, "effort", "motor", per_turn=16).at(1).round(9)  # holds the weight: -m g l cos(angle)
        np.complex128(-4.905+0j)
        """
        wanted = (quantity, part)
        return as_public(
            Spectrum, orders_of(self, lambda times: self.again(output=times), hinge, wanted, per_turn, after)
        )

    def waterfall(
        self,
        hinge: Joint | str,
        quantity: str | Measure,
        part: "Part | None" = None,
        *,
        turns: int = 8,
        per_turn: int = 128,
        after: float | None = None,
    ) -> Waterfall:
        """Return the amplitudes of a quantity over orders of a hinge and its speed, as it runs up or down.

        As `orders`, in windows ("hann") of some turns each that overlap by half.

        Parameters
        ----------
        hinge, quantity, part, per_turn, after
            As in `orders`.
        turns : int
            Of a window: orders are resolved to 2 / turns, while the speed changes over as many turns.

        Returns
        -------
        Waterfall
            ``.at(order)`` over the speed; ``.plot()``, a map over frequency and speed.

        Raises
        ------
        ValueError
            As in `orders`, and if the hinge turns less often than a window.
        """
        wanted = (quantity, part)
        found = waterfall_of(self, lambda times: self.again(output=times), hinge, wanted, turns, per_turn, after)
        return as_public(Waterfall, found)

    def report(
        self,
        path: str | Path | None = None,
        *,
        title: str | None = None,
        curves: "Wanted | None" = None,
        dark: bool | None = None,
    ) -> "Report":
        """Make a page about a run: assessment, certificate, curves, degrees of freedom, and tables of all parts.

        ``path``: where to write it too. ``title``: None = the names of the bodies. ``curves``: one figure each, as for
        `plot`, None = the default ones. ``dark``: dark or light paper, None = as the reader's screen is set; it always
        prints on light paper. ValueError for a solution without samples, an unknown quantity or part, or a folder that
        cannot be written.
        """
        from ..report.page import make_report

        return make_report(self, path, title=title, curves=curves, dark=dark)

    def save(self, path: str | Path) -> Path:
        """Write the solution and its system to one file without pickle, which `mbsd3d.load` reads back.

        ".npz" is appended if missing; an existing file is replaced atomically. All but the function of a `CustomForce`
        is saved. Returns the file; ValueError if a part cannot be described or the folder cannot be written.
        """
        from ..files.solutions import save

        return save(self, path)

    def bundle(self, path: str | Path, *, attach: Iterable[str | Path] = (), comparison: Any = None) -> Path:
        """Write the run with all that is needed to make it again, as evidence for others; `mbsd3d.verify` repeats it.

        The file (.zip) holds the model, the settings, the samples, the certificate with the error estimate (made by two
        tighter runs if it is not there yet), versions and processor, and a digest of each. ``attach``: files to add.
        ``comparison``: the result of `validation.cross_check` for the same system and start: the limits that other
        engines tend to, which `verify` reports.

        Returns the file. ValueError for a run that was interrupted, that cannot be repeated, or whose model holds a
        function, as a `CustomForce` does; IntegrationError where the estimate cannot be made.

        >>> from tempfile import TemporaryDirectory
        >>> from mbsd3d import Body, System, simulate, verify
        >>> stone = Body("stone", 1.0, (0.1, 0.2, 0.3), velocity=(0, 0, 3.0), omega=(0.1, 2.0, 0))
        >>> with TemporaryDirectory() as folder:
        ...     print(verify(simulate(System([stone]), 1.0, output=11).bundle(f"{folder}/flight")).passed)
        True
        """
        from ..files.bundles import write_bundle

        known = self.certificate if self.certificate.error is not None else self.estimate()
        return write_bundle(self.with_certificate(known), path, known, attach, comparison)

    def to_xarray(self) -> "Dataset":
        """Return all quantities as an xarray Dataset.

        ``dataset.to_netcdf(path, engine="h5netcdf")`` writes it; the extra ``netcdf`` installs that engine.

        Returns
        -------
        xarray.Dataset
            Dimensions time, body, joint, driver, own_state (of forces), axis (x, y, z) and quaternion (e0 ... e3);
            every variable carries units, frame and description. Quantities a joint does not have are NaN.
        """
        from ..files.table_files import to_xarray

        return to_xarray(self)

    def to_csv(self, path: str | Path) -> Path:
        """Write a table with one row per sample and one column per component, e.g. ``crank.position.x [m]``.

        The numbers read back equal. ".csv" is appended if missing; an existing file is replaced atomically. Returns the
        file; ValueError if the folder cannot be written.
        """
        from ..files.table_files import to_csv

        return to_csv(self, path)

    def to_dataframe(self) -> "DataFrame":
        """Return a pandas DataFrame, one row a sample, indexed by the time, with the columns of `to_csv`."""
        from ..files.table_files import to_dataframe

        return to_dataframe(self)

    def estimate(self) -> Certificate:
        """Return the certificate with a global error estimate from two tighter runs.

        Adaptive steps: rtol/32 and rtol/1024; fixed steps: dt/2 and dt/4. The error is the largest difference of
        positions (model lengths) and angles [rad] at the samples from the tightest run.
        """
        try:
            return estimate(self)
        except IntegrationError as error:
            publish_solution(error)
            raise

    def with_certificate(self, certificate: Certificate) -> "Solution":
        """Return the same solution with the global error of a certificate of `estimate`."""
        return replace(self, estimated=(certificate.error, certificate.order, certificate.doubling))


def changed(options: RunOptions, changes: Mapping[str, Any]) -> RunOptions:
    """Return options with some arguments of `simulate` instead of their own."""
    given = {name: value for name, value in changes.items() if name in OPTION_NAMES}
    if "method" in given and given["method"] is None:
        given["method"] = DOP853()
    switches = replace(options.switches, **{name: value for name, value in changes.items() if name in SWITCH_NAMES})
    return replace(options, switches=switches, **given)


def publish_solution(error: IntegrationError) -> None:
    """Replace the samples that a failed run leaves by the public `Solution` of them."""
    error.solution = error.solution and Solution.of(error.solution)
