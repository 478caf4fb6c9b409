"""`sliders`: a mechanism with parameters in a notebook, whose picture follows them."""

import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from ..api.system import System
from ..base.checks import number, short_repr
from ..base.errors import InputError, MbsError
from .experiment import check_parameters

if TYPE_CHECKING:
    import ipywidgets

STEPS = 200  # of a slider between its ends
WIDTH = "480px"  # of a slider


def sliders(
    build: Callable[..., System],
    ranges: Mapping[str, Sequence[float]],
    look: Callable[[System], Any] | None = None,
) -> "ipywidgets.VBox":
    """Return sliders for the parameters of a mechanism, and its picture below them, which follows.

    It is displayed as the value of a notebook cell. If a mechanism cannot be built, the reason replaces its picture:
    "cannot close" at the ends of a linkage's range. Needs ipywidgets: ``pip install mbsd3d[notebook]``.

    Parameters
    ----------
    build : callable
        Makes the `System` of some parameters, ``build(**parameters)``, as for `sweep` and `Study`.
    ranges : dict of (low, high)
        The ends of each parameter's slider, in the unit that ``build`` takes. A slider starts at the default of
        ``build`` where that lies between them, else in the middle.
    look : callable, optional
        Makes what is shown of a system: a figure, or anything that shows itself as HTML or text. None = its picture.
        ``lambda system: simulate(system, 2.0).plot("angle")`` shows a run.

    Raises
    ------
    ValueError
        If ``build`` does not take the parameters, an end is no number, the ends are not in order, or ipywidgets is
        missing.

    Examples
    --------
    >>> from mbsd3d import linkages, sliders
    >>> def wiper(crank=0.05, rocker=0.09):
    ...     return linkages.rssr(crank=crank, rod=0.35, rocker=rocker, distance=0.32, twist=1.3, angle=0.4)
    >>> shown = sliders(wiper, {"crank": (0.02, 0.08), "rocker": (0.06, 0.12)})  # doctest: +SKIP
    """
    try:
        import ipywidgets
    except ImportError:
        raise InputError("sliders needs the package ipywidgets; install it: pip install 'mbsd3d[notebook]'") from None
    ends = {name: checked(name, given) for name, given in ranges.items()}
    check_parameters(build, "build", ends, "sliders")
    wide = {"style": {"description_width": "initial"}, "layout": ipywidgets.Layout(width=WIDTH)}
    tracks = {
        name: ipywidgets.FloatSlider(
            start(build, name, low, high), min=low, max=high, step=(high - low) / STEPS, description=name,
            readout_format=".4g", **wide,
        )
        for name, (low, high) in ends.items()
    }  # fmt: skip
    place = ipywidgets.VBox()

    def follow(change: object = None) -> None:
        """Show the mechanism for the present values of the sliders."""
        try:
            system = build(**{name: track.value for name, track in tracks.items()})
            shown = system.picture() if look is None else look(system)
        except MbsError as error:
            shown = str(error)
        place.children = (widget(ipywidgets, shown),)

    for track in tracks.values():
        track.observe(follow, names="value")
    follow()
    return ipywidgets.VBox([*tracks.values(), place])


def checked(name: str, given: Sequence[float]) -> tuple[float, float]:
    """Return the ends of a slider as numbers."""
    if isinstance(given, str) or not isinstance(given, Sequence) or len(given) != 2:
        raise InputError(f"sliders: the range of '{name}' is {short_repr(given)}; give two numbers, (low, high)")
    low, high = (number(value, f"sliders: '{name}'") for value in given)
    if not low < high:
        raise InputError(f"sliders: the range of '{name}' is {low:g} to {high:g}; give the lower end first")
    return low, high


def start(build: Callable[..., System], name: str, low: float, high: float) -> float:
    """Return where a slider starts: at the default of its parameter, or in the middle."""
    known = inspect.signature(build).parameters
    default = known[name].default if name in known else None
    return float(default) if isinstance(default, float | int) and low <= default <= high else (low + high) / 2


def widget(ipywidgets: Any, shown: Any) -> Any:
    """Return a widget that shows an object in a notebook."""
    if hasattr(shown, "_repr_png_"):
        return ipywidgets.Image(value=shown._repr_png_(), format="png")
    if hasattr(shown, "_repr_html_"):
        return ipywidgets.HTML(value=shown._repr_html_())
    return ipywidgets.Textarea(value=str(shown), disabled=True, layout=ipywidgets.Layout(width="100%", height="6em"))
