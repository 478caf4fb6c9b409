from ..api.playing import Play as Play
from ..api.playing import play_model as play_model
from ..run.live_model import Playable as Playable
from ..run.live_model import Built as Built
from ..run.live_model import Control as Control
from ..run.live_model import Panel as Panel
from ..run.live_model import Seen as Seen
