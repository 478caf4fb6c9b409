"""A model that is played in a browser: from its options to a `Play`."""

from collections.abc import Sequence

from ..base.checks import short_repr as shown_text
from ..base.errors import InputError
from ..integrators.dop853 import DOP853
from ..integrators.method import Method
from ..mechanism.bodies import Body
from ..results.record import RunOptions
from ..run.live_model import Playable
from ..run.live_run import Playing
from ..view.page.recorder import import_viser
from ..view.page.show import check_options, page_layers
from ..view.play import play
from ..view.play.play_page import Look
from ..view.scene.camera import number_of
from ..view.scene.drawing import Layers, title_of
from .solution import Solution
from .viewable import LayerNames


class Play(play.Play):
    """A model that is played in a browser; a context manager that ends it.

    ::

        with system.play({"push": (-5, 5)}) as play:
            play.open()
            play.wait()
        play.solution().plot()
    """

    def solution(self) -> Solution:
        """Return the live run so far, of at most the last ten minutes: a `Solution` with a sample every 1/60 s."""
        return Solution.of(super().solution())


def play_model(
    model: Playable,
    *,
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
) -> Play:
    """Play a model of your own: its controls, curves, and how it is made anew; the options are those of `System.play`.

    Raises
    ------
    ValueError
        For an invalid option, a port in use, or a missing package.
    AssemblyError, IntegrationError
        If the model cannot start.
    """
    import_viser("play")
    options = RunOptions(DOP853() if method is None else method, rtol, as_built=as_built)
    playing = Playing(model, options)
    system = playing.built.system
    check_options(None, title, dark, False)
    if type(port) is not int or not 0 <= port <= 65535:
        raise InputError(f"play: port = {shown_text(port)}; give a whole number up to 65535, or 0 for any that is free")
    followed = -1 if follow is None else number_of(system, follow)
    look = Look(title or title_of(system), page_layers(system, Layers(shown, hidden)), followed, view, dark)
    return Play(playing, look, port)
