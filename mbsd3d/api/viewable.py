"""What can be seen of a motion: the methods by which solutions and modes are drawn, animated and exported.

One vocabulary for all of them, and for systems (`mbsd3d.api.drawable`): ``shown`` and ``hidden`` name layers besides
and without the usual ones, which are bodies, joints, springs and rods, traces, ground grid, and names where there are
few: "bodies", "body names", "joints", "joint names", "springs and rods", "traces", "ground grid", "angular velocity",
"angular momentum", "reaction force", "reaction moment", "centre of mass", "reference point".
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..mechanism.bodies import Body, Ground
    from ..plotting.panels import Wanted
    from ..view.page.html import View
    from ..view.page.live import LiveView
    from ..view.scene.motion import Points

Layers = str | Sequence[str]


class Viewable:
    """A run or a mode: what is drawn of it moves."""

    def animate(
        self,
        path: str | Path | None = None,
        *,
        curves: "Wanted | None" = None,
        traces: "Points | None" = None,
        shown: Layers = (),
        hidden: Layers = (),
        frames: int | None = None,
        speed: float | None = None,
        title: str | None = None,
        dark: bool | None = None,
        live: bool = False,
        follow: "Body | Ground | str | None" = None,
    ) -> "View | LiveView":
        """A page that shows the motion in space and curves beside it; one HTML file that needs no network.

        Parameters
        ----------
        path : str or Path, optional
            Where the page is written too; ".html" is appended if it is missing.
        curves : list of quantities as `plot` takes them, or of (quantity, part, ...), optional
            None = a few that tell most; () = none. A mode has none.
        traces : list of bodies, or of (body, world point at the reference pose [m]), optional
            Points whose paths are drawn; None = centres of mass that move; () = none.
        shown, hidden : layer or list of layers, optional
            From the start besides and without the usual ones, e.g. ["angular momentum"], see `mbsd3d.api.viewable`;
            all have switches.
        frames : int, optional
            >= 2; None = as many as the motion needs and the page bears.
        speed : float, optional
            Model time per real time; None = real time for runs of 2 ... 30 s, else a round factor for about 10 s.
        title : str, optional
        dark : bool, optional
            None = what the reader's system prefers.
        live : bool
            Whether a server on this machine shows the motion instead (``path`` is not written then).
        follow : Body, str or GROUND, optional
            Body that the camera of a page goes along with, seen from near; None = all of the motion is seen, or the
            heaviest body is followed where it travels 20 times the size of the mechanism; GROUND = the camera stands.
            The reader may choose another one.

        Returns
        -------
        View
            With ``.html``, ``.save(path)`` and ``.open()``; shown by notebooks. With ``live`` a `LiveView`.

        Raises
        ------
        ValueError
            Naming the option, part or package and the remedy.
        """
        from ..view.page.show import animate

        return animate(
            self, path, curves=curves, traces=traces, shown=shown, hidden=hidden, frames=frames, speed=speed,
            title=title, dark=dark, live=live, follow=follow,
        )  # fmt: skip

    def picture(
        self,
        t: float | Sequence[float] | None = None,
        *,
        traces: "Points | None" = None,
        shown: Layers = (),
        hidden: Layers = (),
        view: Sequence[float] | None = None,
        size: Sequence[float] = (6.4, 4.8),
        dark: bool = False,
    ) -> "Figure":
        """A shaded matplotlib figure of a moment, or of several in one picture, with the time in it.

        Parameters
        ----------
        t : float, sequence of float, or None
            Time [s]; several = a multiple exposure; None = the last one.
        traces : list of bodies, or of (body, world point at the reference pose [m]), optional
            Points whose paths until then (of several times: from the first to the last) are drawn; None = centres of
            mass that move; () = none.
        shown, hidden : layer or list of layers, optional
            Besides and without the usual ones, see `mbsd3d.api.viewable`; names are written if there are at most 14.
            Arrows are to scale within a kind, of which the legend gives the longest; shares that the constraints leave
            open are pale.
        view, size, dark
            See `System.picture`.

        Returns
        -------
        matplotlib.figure.Figure
            Not shown; `mbsd3d.save_figure` writes it.

        Raises
        ------
        ValueError
            If a time is outside the run, a part or a layer is unknown, or an option is invalid.
        """
        from ..view.picture.picture import picture_of_solution

        options = {"traces": traces, "shown": shown, "hidden": hidden, "view": view, "size": size, "dark": dark}
        return picture_of_solution(self, t, **options)

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
        shown: Layers = (),
        hidden: Layers = (),
        view: Sequence[float] | None = None,
        dark: bool = False,
    ) -> Path:
        """Write the motion as an animated GIF that repeats for ever; the same run gives the same bytes.

        Parameters
        ----------
        path : str or Path
            ".gif" is appended if it is missing.
        fps : float
            Frames per second of the film > 0, at most 50 (viewers slow down what is faster).
        speed : float, optional
            Model time per real time; None = real time for runs of 2 ... 6 s, else a round factor for about 4 s.
        width, height : int
            Of the scene [pixel]; height None = 3/4 of the width; curves come below.
        curves : list, optional
            Below the scene, as in `animate`; None = a few that tell most; () = none.
        traces, shown, hidden, view, dark
            See `picture`.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        ValueError
            If an option is invalid, the folder does not exist, or the run has a single moment.
        """
        from ..view.film.film import export_gif

        options = {"curves": curves, "traces": traces, "shown": shown, "hidden": hidden, "view": view, "dark": dark}
        return export_gif(self, path, fps=fps, speed=speed, width=width, height=height, **options)

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
        shown: Layers = (),
        hidden: Layers = (),
        view: Sequence[float] | None = None,
        dark: bool = False,
    ) -> Path:
        """Write the motion as an MP4 film (H.264, yuv420p: plays everywhere) through ffmpeg.

        Parameters
        ----------
        path : str or Path
            ".mp4" is appended if it is missing.
        fps : float
            Frames per second of the film > 0.
        speed : float, optional
            Model time per real time; None = as `animate`.
        width, height : int
            As for `export_gif`, even.
        curves, traces, shown, hidden, view, dark
            See `export_gif`.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        ValueError
            If there is no ffmpeg, a size is odd, or as for `export_gif`.
        """
        from ..view.film.film import export_mp4

        options = {"curves": curves, "traces": traces, "shown": shown, "hidden": hidden, "view": view, "dark": dark}
        return export_mp4(self, path, fps=fps, speed=speed, width=width, height=height, **options)

    def export_glb(self, path: str | Path, *, frames: int | None = None, traces: "Points | None" = None) -> Path:
        """Write the motion as an animated glTF 2.0 file, which Blender, three.js and most 3D viewers open.

        One node per body, of its name, with its shape, its joints, and animated translation and rotation in metres
        and seconds from the first frame on; a root node turns z up to glTF's y up. Springs stretch.

        Parameters
        ----------
        path : str or Path
            ".glb" is appended if it is missing; an older file is replaced in one go.
        frames : int, optional
            Number of frames in equal steps of time; None = enough for a smooth film.
        traces : sequence of (body, (3,) array_like), optional
            Points whose paths are drawn, in world coordinates at the reference pose [m]; None = centres of mass that
            move, () = none.

        Returns
        -------
        Path
            The file; the same solution gives the same bytes.

        Raises
        ------
        ValueError
            If the package pygltflib is missing, there is no sample, a shape cannot be drawn, a point's body is not in
            the system, or the folder cannot be written.
        """
        from ..view.gltf.export import export_run

        return export_run(self, path, frames, traces)
