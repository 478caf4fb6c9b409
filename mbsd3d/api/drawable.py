"""Drawing and exporting a system at rest; `mbsd3d.api.viewable` does it for motions."""

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
    """Pictures of a system at rest."""

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
        """A shaded matplotlib figure; `mbsd3d.save_figure` writes it.

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

        return picture_of_system(self, state, shown=shown, hidden=hidden, view=view, size=size, dark=dark)

    def export_glb(self, path: str | Path) -> Path:
        """Write the reference pose as a glTF 2.0 file; see `Solution.export_glb`."""
        from ..view.gltf.export import export_pose

        return export_pose(self, path)
