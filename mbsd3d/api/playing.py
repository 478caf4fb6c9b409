"""A model that is played in a browser: from its options to a `Play`."""

from collections.abc import Sequence

from ..integrators.method import Method
from ..mechanism.bodies import Body
from ..run.playable import Playable
from ..run.playing import Playing
from ..view.page.recorder import import_viser
from ..view.play.play import Play, play
from .replay import played
from .viewable import Layers


def play_model(
    model: Playable,
    *,
    method: Method | None = None,
    rtol: float = 1e-6,
    as_built: float | None = None,
    shown: Layers = (),
    hidden: Layers = (),
    follow: Body | str | None = None,
    view: Sequence[float] | None = None,
    title: str | None = None,
    dark: bool | None = None,
    port: int = 0,
) -> Play:
    """Play a model of your own: its controls, curves, and how it is made anew; the options are those of `System.play`.

    Raises
    ------
    ValueError
        For an option that makes no sense, a port in use, or a missing package.
    AssemblyError, IntegrationError
        If the model cannot start.
    """
    import_viser("play")
    return play(
        Playing(model, method, rtol, as_built), shown=shown, hidden=hidden, follow=follow, view=view, title=title,
        dark=dark, port=port, as_solution=played,
    )  # fmt: skip
