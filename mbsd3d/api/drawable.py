"""What can be seen of a system: the methods by which it is drawn and exported; what moves is `mbsd3d.api.viewable`."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ..mechanism.state import State
from .viewable import Layers

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..view.page.html import View
    from ..view.page.live import LiveView


class Drawable:
    """A system: what is drawn of it stands still."""

    def show(
        self,
        path: str | Path | None = None,
        *,
        state: State | None = None,
        shown: Layers = (),
        hidden: Layers = (),
        title: str | None = None,
        dark: bool | None = None,
        live: bool = False,
    ) -> "View | LiveView":
        """A page that shows the mechanism in space; one HTML file that needs no network.

        Parameters
        ----------
        path : str or Path, optional
            Where the page is written too; ".html" is appended if it is missing.
        state : State, optional
            None = the reference pose.
        shown, hidden : layer or list of layers, optional
            From the start besides and without the usual ones, see `mbsd3d.api.viewable`; all have switches.
        title : str, optional
        dark : bool, optional
            None = what the reader's system prefers.
        live : bool
            Whether a server on this machine shows it instead (``path`` is not written then).

        Returns
        -------
        View
            With ``.html``, ``.save(path)`` and ``.open()``; shown by notebooks. With ``live`` a `LiveView`.

        Raises
        ------
        ValueError
            For a state of another system, a shape that cannot be drawn, an unknown layer, a missing package.
        """
        from ..view.page.show import show_system

        return show_system(self, path, state, shown, hidden, title, dark, live)

    def picture(
        self,
        state: State | None = None,
        *,
        shown: Layers = (),
        hidden: Layers = (),
        view: Sequence[float] | None = None,
        size: Sequence[float] = (6.4, 4.8),
        dark: bool = False,
    ) -> "Figure":
        """A shaded matplotlib figure.

        Parameters
        ----------
        state : State or None
            Pose; None = the reference pose.
        shown, hidden : layer or list of layers, optional
            Besides and without the usual ones, see `mbsd3d.api.viewable`; names are written if there are at most 14.
            "ground grid" is the floor under the lowest point, with the shadows of a high sun.
        view : (float, float) or None
            Azimuth (from x about z) and elevation of the eye [degrees]; None = the view of `show`.
        size : (float, float)
            Width and height [inch].
        dark : bool
            On dark paper.

        Returns
        -------
        matplotlib.figure.Figure
            Not shown; `mbsd3d.save_figure` writes it.

        Raises
        ------
        ValueError
            If the state is one of another system, a shape cannot be drawn, or an option is invalid.
        """
        from ..view.picture.picture import picture_of_system

        return picture_of_system(self, state, shown=shown, hidden=hidden, view=view, size=size, dark=dark)

    def export_glb(self, path: str | Path) -> Path:
        """Write the reference pose as a glTF 2.0 file; see `Solution.export_glb`."""
        from ..view.gltf.export import export_pose

        return export_pose(self, path)
