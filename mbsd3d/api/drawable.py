"""Drawing, exporting and playing a system; `mbsd3d.api.viewable` draws motions."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypedDict, Unpack, overload

from ..integrators.method import Method
from ..mechanism.bodies import Body
from ..mechanism.measures import Measure
from ..mechanism.mechanism import Mechanism
from ..mechanism.signals.signal import InputOrName
from ..mechanism.state import State
from .viewable import LayerNames

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..view.page.html import View
    from ..view.page.live import LiveView
    from .playing import Play


class ShowOptions(TypedDict, total=False):
    """Options of `System.show`."""

    state: State | None
    shown: LayerNames
    hidden: LayerNames
    title: str | None
    dark: bool | None


class Drawable(Mechanism):
    """Pictures of a system at rest, and playing with it."""

    if TYPE_CHECKING:

        def state(self, *, as_built: float | None = None) -> State: ...

    @overload
    def show(
        self, path: str | Path | None = None, *, live: Literal[False] = False, **options: Unpack[ShowOptions]
    ) -> "View": ...
    @overload
    def show(
        self, path: str | Path | None = None, *, live: Literal[True], **options: Unpack[ShowOptions]
    ) -> "LiveView": ...
    @overload
    def show(
        self, path: str | Path | None = None, *, live: bool, **options: Unpack[ShowOptions]
    ) -> "View | LiveView": ...
    def show(
        self,
        path: str | Path | None = None,
        *,
        state: State | None = None,
        shown: LayerNames = (),
        hidden: LayerNames = (),
        title: str | None = None,
        dark: bool | None = None,
        live: bool = False,
    ) -> "View | LiveView":
        """Return a page that shows the mechanism in space; one HTML file that needs no network.

        The `View` has ``.html``, ``.save(path)`` and ``.open()``; notebooks show it. With ``live`` it is a `LiveView`.
        ValueError for a state of another system, a shape that cannot be drawn, an unknown layer, a missing package.

        Parameters
        ----------
        path : str or Path, optional
            The page is also written there; ".html" is appended if missing.
        state : State, optional
            None = the reference pose.
        shown, hidden : layer or list of layers, optional
            Added to and removed from the usual layers at the start, see `mbsd3d.api.viewable`. The page has a switch
            for each.
        title : str, optional
        dark : bool, optional
            None = what the reader's system prefers.
        live : bool
            Show it by a server on this machine instead; ``path`` is not written then.
        """
        from ..view.page.show import show_system
        from ..view.scene.drawing import Layers

        return show_system(self, path, state, Layers(shown, hidden), title, dark, live)

    def picture(
        self,
        state: State | None = None,
        *,
        shown: LayerNames = (),
        hidden: LayerNames = (),
        view: Sequence[float] | None = None,
        size: Sequence[float] = (6.4, 4.8),
        dark: bool = False,
    ) -> "Figure":
        """Draw a shaded matplotlib figure; `mbsd3d.save_figure` writes it.

        ValueError if the state is one of another system, a shape cannot be drawn, or an option is invalid.

        Parameters
        ----------
        state : State or None
            Pose; None = the reference pose.
        shown, hidden : layer or list of layers, optional
            Added to and removed from the usual layers, see `mbsd3d.api.viewable`; names appear if there are at most 14.
            "ground grid" is the floor under the lowest point, with the shadows of a high sun.
        view : (float, float) or None
            Azimuth (from x about z) and elevation of the eye [degrees]; None = the view of `show`.
        size : (float, float)
            Width and height [inch].
        dark : bool
            On dark paper.
        """
        from ..view.picture.picture import picture_of_system
        from ..view.scene.drawing import Layers

        return picture_of_system(self, state, layers=Layers(shown, hidden), view=view, size=size, dark=dark)

    def export_glb(self, path: str | Path) -> Path:
        """Write the reference pose as a glTF 2.0 file; see `Solution.export_glb`."""
        from ..view.gltf.export import export_pose

        return export_pose(self, path)

    def play(
        self,
        inputs: Mapping[InputOrName, Sequence[float]] | None = None,
        *,
        state: State | None = None,
        curves: Sequence[Measure] | None = None,
        method: Method | None = None,
        rtol: float = 1e-6,
        as_built: float | None = None,
        shown: LayerNames = (),
        hidden: LayerNames = (),
        follow: Body | str | None = None,
        view: Sequence[float] | None = None,
        title: str | None = None,
        dark: bool | None = None,
        port: int = 0,
    ) -> "Play":
        """Run the system in real time in a browser on this machine, and change its inputs meanwhile.

        The page has a slider and keys for each input, pause, reset, slow motion, curves of the last ten seconds, and
        saves the ride. The `Play` has ``.open()``, ``.wait()`` until Ctrl-C, ``.set(name, value)``, ``.t``,
        ``.late`` (frames that were not ready in time), ``.solution()`` and ``.stop()``. Only the browser that was
        given its ``.url`` is let in.

        Parameters
        ----------
        inputs : mapping of an `Input` or its name to (low, high), in the unit of what it drives
            Pressed keys hold an end of the range: left and right arrow (or J, L) of the first input, down and up (or
            K, I) of the second, A, D and S, W of the next two. Other inputs stay what they are.
        state : State or None
            Start, also of every reset; None = ``system.state()``.
        curves : sequence of measures, optional
            Drawn while it moves, by unit; None = angles and slides of joints.
        method, rtol, as_built
            As for `Stepper`; a frame is a segment of 1/60 s.
        shown, hidden : layer or list of layers, optional
            Added to and removed from the usual layers at the start, see `mbsd3d.api.viewable`.
        follow : Body, str or None
            Body that the camera goes along and turns with.
        view : (float, float) or None
            First azimuth (from x about z) and elevation of the eye [degrees]; None = as in `show`.
        title, dark
            As for `show`.
        port : int
            On this machine; 0 = any free port.

        Raises
        ------
        ValueError
            For an unknown input or one that prescribes a motion, a reversed range or one without the value at the
            start, a port that is in use, a missing package.
        AssemblyError, IntegrationError
            If the system cannot start.

        Examples
        --------
        >>> from mbsd3d import Body, Force, Input, System
        >>> sled = Body("sled", 2.0, (0.1, 0.1, 0.1), velocity=(0, 0, 0), omega=(0, 0, 0))
        >>> system = System([sled], forces=[Force(sled, (Input("push"), 0, 19.62))])
        >>> with system.play({"push": (-5, 5)}) as play:  # doctest: +SKIP
        ...     play.open()
        ...     play.wait()
        """
        from ..run.live_model import plain
        from ..run.simulation import check_state
        from .playing import play_model

        check_state(state, "play")
        model = plain(self, state or self.state(as_built=as_built), inputs, curves)
        return play_model(
            model, method=method, rtol=rtol, as_built=as_built, shown=shown, hidden=hidden, follow=follow, view=view,
            title=title, dark=dark, port=port,
        )  # fmt: skip
