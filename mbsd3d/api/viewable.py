"""Drawing, animating and exporting solutions and modes.

Systems (`mbsd3d.api.drawable`) use the same options: ``shown`` adds layers to the usual ones, ``hidden`` removes some.
Usual are bodies, joints, springs and rods, traces, the ground grid, and names that fit. All layers:
"bodies", "body names", "joints", "joint names", "springs and rods", "traces", "ground grid", "angular velocity",
"angular momentum", "reaction force", "reaction moment", "engaged" (an arrow along the axis of a part that switches,
while it holds), "inertia ellipsoids" (of bodies drawn as links: those without a shape between joints at two points or
more), "centre of mass", "reference point".
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypedDict, Unpack, overload

from numpy.typing import ArrayLike

from ..results.motion import Motion

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..mechanism.bodies import Body, Ground
    from ..plotting.panels import Wanted
    from ..view.explore.exploration import Exploration
    from ..view.explore.ridden import Ride
    from ..view.page.html import View
    from ..view.page.live import LiveView
    from ..view.scene.overlays import Points

LayerNames = str | Sequence[str]


class AnimateOptions(TypedDict, total=False):
    """Options of `Solution.animate`."""

    curves: "Wanted | None"
    traces: "Points | None"
    shown: LayerNames
    hidden: LayerNames
    frames: int | None
    speed: float | None
    title: str | None
    dark: bool | None
    follow: "Body | Ground | str | None"
    view: Sequence[float] | None
    beside: Motion | None
    explore: "Exploration | None"
    ride: "Ride | None"
    captions: Sequence[tuple[float, str]]


class Viewable(Motion):
    """Pictures and films of a run or a mode."""

    @overload
    def animate(
        self, path: str | Path | None = None, *, live: Literal[False] = False, **options: Unpack[AnimateOptions]
    ) -> "View": ...
    @overload
    def animate(
        self, path: str | Path | None = None, *, live: Literal[True], **options: Unpack[AnimateOptions]
    ) -> "LiveView": ...
    @overload
    def animate(
        self, path: str | Path | None = None, *, live: bool, **options: Unpack[AnimateOptions]
    ) -> "View | LiveView": ...
    def animate(
        self,
        path: str | Path | None = None,
        *,
        curves: "Wanted | None" = None,
        traces: "Points | None" = None,
        shown: LayerNames = (),
        hidden: LayerNames = (),
        frames: int | None = None,
        speed: float | None = None,
        title: str | None = None,
        dark: bool | None = None,
        live: bool = False,
        follow: "Body | Ground | str | None" = None,
        view: Sequence[float] | None = None,
        beside: Motion | None = None,
        explore: "Exploration | None" = None,
        ride: "Ride | None" = None,
        captions: Sequence[tuple[float, str]] = (),
    ) -> "View | LiveView":
        """Return a page that shows the motion in space and curves beside it; one HTML file that needs no network.

        The `View` has ``.html``, ``.save(path)`` and ``.open()``; notebooks show it. With ``live`` it is a `LiveView`.
        ValueError naming the option, part or package and the remedy.

        Parameters
        ----------
        path : str or Path, optional
            The page is also written there; ".html" is appended if missing.
        curves : list of quantities as `plot` takes them, or of (quantity, part, ...), optional
            None = the most telling ones; () = none. A mode has none.
        traces : list of bodies, of (body, world point at the reference pose [m]), or of (body, point, base), optional
            Points whose paths are drawn; None = centres of mass that move; () = none.
        shown, hidden : layer or list of layers, optional
            Added to and removed from the usual layers at the start, e.g. ["angular momentum"]; see
            `mbsd3d.api.viewable`. The page has a switch for each.
        frames : int, optional
            >= 2; None = as many as the motion needs and the page bears.
        speed : float, optional
            Model time per real time; None = real time for runs of 2 ... 30 s, else a round factor for about 10 s.
        title : str, optional
        dark : bool, optional
            None = what the reader's system prefers.
        live : bool
            Show the motion by a server on this machine instead; ``path`` is not written then.
        follow : Body, str or GROUND, optional
            Body that the camera of a page follows from near; None = the view holds the whole motion, or follows the
            heaviest body where it travels 20 times the size of the mechanism; GROUND = the camera stands. The reader
            may choose another body.
        view : (2,) array_like, optional
            Azimuth from x about z and elevation of the first camera [degrees]; None = the usual view.
        beside : Solution, optional
            Another run, of whose motion the first view of a page holds as much, and whose arrows have the same scale,
            so that two pages can be compared.
        explore : Exploration, optional
            Sliders, terms and a second run with which the page solves the mechanism itself.
        ride : Ride, optional
            Mechanism that the reader moves himself in the page, by keys or buttons.
        captions : list of (time [s], text), optional
            Sentences below the scene of a page, each from its time on; the film stops there for a moment.
        """
        from ..view.page.show import MotionOptions, animate
        from ..view.scene.drawing import Layers

        options = MotionOptions(
            Layers(shown, hidden), curves, traces, frames, speed, title=title, follow=follow, view=view, beside=beside,
            explore=explore, ride=ride, captions=captions,
        )  # fmt: skip
        return animate(self, path, options, dark, live)

    def picture(
        self,
        t: ArrayLike | None = None,
        *,
        traces: "Points | None" = None,
        shown: LayerNames = (),
        hidden: LayerNames = (),
        follow: "Body | Ground | str | None" = None,
        view: Sequence[float] | None = None,
        size: Sequence[float] = (6.4, 4.8),
        dark: bool = False,
    ) -> "Figure":
        """Draw a shaded matplotlib figure of a moment, or of several in one picture, with the time in it.

        `mbsd3d.save_figure` writes it. ValueError if a time is outside the run, a part or a layer is unknown, or an
        option is invalid.

        Parameters
        ----------
        t : float, sequence of float, or None
            Time [s]; several = a multiple exposure; None = the last one.
        traces : list of bodies, of (body, world point at the reference pose [m]), or of (body, point, base), optional
            Points whose paths until then (of several times: from the first to the last) are drawn; None = centres of
            mass that move; () = none.
        shown, hidden : layer or list of layers, optional
            Added to and removed from the usual layers, see `mbsd3d.api.viewable`; names appear if there are at most 14.
            Arrows are to scale within a kind, of which the legend gives the longest; shares that the constraints leave
            open are pale.
        follow : Body, str or GROUND, optional
            Body that the camera goes along with, as in `animate`, of several times to the last one; paths are cut off
            then. None with several times = the picture holds all.
        view, size, dark
            See `System.picture`.
        """
        from ..view.picture.picture import picture_of_solution
        from ..view.scene.drawing import Layers

        return picture_of_solution(
            self, t, traces=traces, layers=Layers(shown, hidden), view=view, size=size, dark=dark, follow=follow
        )

    def export_gif(
        self,
        path: str | Path,
        *,
        fps: float = 25,
        speed: float | None = None,
        width: int = 480,
        height: int | None = None,
        curves: "Wanted | None" = (),
        traces: "Points | None" = None,
        shown: LayerNames = (),
        hidden: LayerNames = (),
        follow: "Body | Ground | str | None" = None,
        view: Sequence[float] | None = None,
        dark: bool = False,
    ) -> Path:
        """Write the motion as an animated GIF that loops; the same run gives the same bytes. Returns the file.

        ValueError if an option is invalid, the folder does not exist, or the run has a single moment.

        Parameters
        ----------
        path : str or Path
            ".gif" is appended if missing.
        fps : float
            Frames per second of the film > 0, at most 50 (viewers play faster ones slowly).
        speed : float, optional
            Model time per real time; None = real time for runs of 2 ... 6 s, else a round factor for about 4 s.
        width, height : int
            Of the scene [pixel]; height None = 3/4 of the width; curves come below.
        curves : list, optional
            Below the scene, as in `animate`; None = the most telling ones; () = none.
        follow : Body, str or GROUND, optional
            Body that the camera goes along with, as in `animate`.
        traces, shown, hidden, view, dark
            See `picture`.
        """
        from ..view.film.film import export_gif
        from ..view.scene.drawing import Layers

        return export_gif(
            self, path, fps=fps, speed=speed, width=width, height=height, curves=curves, traces=traces,
            layers=Layers(shown, hidden), view=view, dark=dark, follow=follow,
        )  # fmt: skip

    def export_mp4(
        self,
        path: str | Path,
        *,
        fps: float = 25,
        speed: float | None = None,
        width: int = 960,
        height: int | None = None,
        curves: "Wanted | None" = (),
        traces: "Points | None" = None,
        shown: LayerNames = (),
        hidden: LayerNames = (),
        follow: "Body | Ground | str | None" = None,
        view: Sequence[float] | None = None,
        dark: bool = False,
    ) -> Path:
        """Write the motion as an MP4 film (H.264, yuv420p: plays everywhere) through ffmpeg.

        Options as `export_gif`, with these differences: ``fps`` has no upper limit, ``speed`` None means as `animate`,
        ``width`` and ``height`` are even. ValueError also if ffmpeg is missing.
        """
        from ..view.film.film import export_mp4
        from ..view.scene.drawing import Layers

        return export_mp4(
            self, path, fps=fps, speed=speed, width=width, height=height, curves=curves, traces=traces,
            layers=Layers(shown, hidden), view=view, dark=dark, follow=follow,
        )  # fmt: skip

    def export_glb(self, path: str | Path, *, frames: int | None = None, traces: "Points | None" = None) -> Path:
        """Write the motion as an animated glTF 2.0 file, which Blender, three.js and most 3D viewers open; returns the
        file.

        One node per body, of its name, with its shape, its joints, and animated translation and rotation in metres and
        seconds from the first frame on; a root node turns z up to glTF's y up. Springs stretch. ".glb" is appended if
        missing; the same solution gives the same bytes.

        ``frames``: their number in equal steps of time, None = enough for a smooth film. ``traces``: points whose paths
        are drawn, as in `animate`. ValueError if there is no sample, a shape cannot
        be drawn, a point's body is not in the system, or the folder cannot be written.
        """
        from ..view.gltf.export import export_run

        return export_run(self, path, frames, traces)
