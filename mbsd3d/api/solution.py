"""The public `Solution`: the result of a run, and what can be done with it."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base.style import html_text
from ..mechanism.state import State
from ..results.certificate import Certificate, estimate
from ..results.run_result import RunResult
from .viewable import Viewable

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from ..plotting.panels import Part, Wanted
    from ..report.page import Report


@dataclass(frozen=True, eq=False, repr=False)
class Solution(RunResult, Viewable):
    """Samples of a run. Parts are given as objects or by name; vectors are (samples, 3) in world axes.

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

    simulate: Callable[..., "Solution"] = field(kw_only=True)

    def __repr__(self) -> str:
        span = f"{self.t[0]:g} ... {self.t[-1]:g} s" if self.t.size else "nothing"
        name = f" of {self.system.title!r}" if self.system.title else ""
        return f"<solution{name}: {self.t.size} samples, {span}, by {self.record.method}; print(solution.certificate)>"

    def _repr_html_(self) -> str:
        return html_text(f"{repr(self).strip('<>').partition('; print')[0]}\n{self.certificate}")

    @classmethod
    def of(cls, result: RunResult, simulate: Callable[..., "Solution"]) -> "Solution":
        """The solution of a result: the same numbers, and how to run again."""
        return cls(**{x.name: getattr(result, x.name) for x in fields(RunResult)}, simulate=simulate)

    def at(self, t: float) -> State:
        """The state at any time of the run [s], by integrating on from the sample before it."""
        if not self.t[0] <= t <= self.final.t:
            raise ValueError(f"solution.at: t = {t:g} s is outside the run {self.t[0]:g} ... {self.final.t:g} s")
        k = int(np.searchsorted(self.t, t, side="right")) - 1
        start = self.state(k)
        same = t - start.t <= 4.0 * np.spacing(max(abs(t), abs(self.final.t)))  # too short for any step
        return start if same else self.again(t, state=start, output=[t]).final

    def again(self, t_end: float | None = None, **changes: Any) -> "Solution":
        """Run the same system again with the same settings, except for the given ones (see `simulate`)."""
        settings = {**asdict(self.record.switches), "rtol": self.record.rtol, "method": self.record.method}
        settings.update(state=self.state(0), output=self.t)
        if self.record.tolerance:
            settings["as_built"] = self.record.tolerance * self.compiled.model.length
        settings.update(changes)
        return self.simulate(self.system, self.final.t if t_end is None else t_end, **settings)

    def plot(
        self,
        quantity: "str | Wanted" = "energy",
        *parts: "Part",
        against: str | tuple | None = None,
        degrees: bool = False,
        dark: bool = False,
        axes: "Axes | Sequence[Axes] | None" = None,
    ) -> "Figure":
        """Figure of a quantity over time, e.g. ``plot("angle", hinge)``; see `mbsd3d.plotting.plots.plot_quantity`."""
        from ..plotting.plots import plot_quantity

        return plot_quantity(self, quantity, *parts, against=against, degrees=degrees, dark=dark, axes=axes)

    def report(
        self,
        path: str | Path | None = None,
        *,
        title: str | None = None,
        curves: "Wanted | None" = None,
        dark: bool | None = None,
    ) -> "Report":
        """One offline page: certificate, curves, tables of all parts; see `mbsd3d.report.page.make_report`."""
        from ..report.page import make_report

        return make_report(self, path, title=title, curves=curves, dark=dark)

    def save(self, path: str | Path) -> Path:
        """Write the solution and its system to one file (.npz, no pickle); `mbsd3d.load` reads it back."""
        from ..files.solutions import save

        return save(self, path)

    def to_xarray(self) -> Any:
        """An xarray Dataset with named bodies and joints, units and frames in the attributes."""
        from ..files.tables import to_xarray

        return to_xarray(self)

    def to_csv(self, path: str | Path) -> Path:
        """A table with one column per component, names and units in the header."""
        from ..files.tables import to_csv

        return to_csv(self, path)

    def to_dataframe(self) -> Any:
        """A pandas DataFrame, one row a sample, indexed by the time, with the columns of `to_csv`."""
        from ..files.tables import to_dataframe

        return to_dataframe(self)

    def estimate(self) -> Certificate:
        """The certificate with a global error estimate from two tighter runs; see `certificate.estimate`."""
        return estimate(self)

    def with_certificate(self, certificate: Certificate) -> "Solution":
        """The same solution with the global error and order of a certificate of `estimate`."""
        return replace(self, estimated=(certificate.error, certificate.order))
