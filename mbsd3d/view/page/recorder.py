"""Scene of viser without a server: no port, no thread, nothing on the terminal; the same calls give the same bytes.

viser's scene writes messages to whatever owns it; here they are kept, and its own serializer turns them into the text
that its client reads. Private parts of viser are used here and nowhere else, and its version is checked.
"""

import base64
import threading
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, get_type_hints

from ...base.errors import InputError
from ...base.version import loading

if TYPE_CHECKING:
    from types import ModuleType

    from viser._messages import Message

CLIENT_VERSION_PREFIX = "1.1."  # of the client that the player of this package drives


def import_viser(user: str) -> "ModuleType":
    """Import viser; raise an error that starts with ``user`` if it is missing or of another version."""
    try:
        with loading():
            import viser
    except ImportError:
        found = "none"
    else:
        found = viser.__version__
    if not found.startswith(CLIENT_VERSION_PREFIX):
        raise InputError(
            f"{user} needs viser {CLIENT_VERSION_PREFIX}x, found {found}; "
            f"install it: pip install 'viser=={CLIENT_VERSION_PREFIX}*'"
        )
    remember_hints()
    return viser


def remember_hints() -> None:
    """Let viser look up the types of a node's properties once for each kind of node.

    It does so for every single node, which is 40 % of the time that a scene of a thousand bodies takes.
    """
    from viser import _assignable_props_api as properties

    if properties.get_type_hints is get_type_hints:
        vars(properties)["get_type_hints"] = cache(get_type_hints)


class Recorder:
    """Owner and connection of viser's scene: it keeps messages and receives nothing."""

    client_id = ""  # the scope of all clients

    def __init__(self) -> None:
        self._websock_connection = self._viser_server = self
        self._scene_lifecycle_lock = threading.RLock()
        self.messages: dict[str, Message] = {}  # by what makes a message replace an older one

    def register_handler(self, *_: object) -> None:
        """Ignore the handler, since nothing is ever received."""

    def queue_message(self, message: "Message") -> None:
        """Keep a message."""
        self.messages[message.redundancy_key()] = message


class Recording:
    """Scene to draw into with viser's ``add_...``; ``data()`` then returns what the client's page holds."""

    def __init__(self, user: str) -> None:
        viser = import_viser(user)
        self.recorder = Recorder()
        self.scene = viser.SceneApi(self.recorder, None, None)
        self.camera = viser.InitialCameraConfig(self.recorder.queue_message)
        self.scene.set_up_direction("+z")

    def data(self) -> str:
        """Return the scene as base64 text."""
        from viser.infra import WebsockMessageHandler

        handler = WebsockMessageHandler()  # type: ignore[abstract]  # only its buffer, which is not used, is abstract
        serializer = handler.get_message_serializer(lambda _: True)
        for message in self.recorder.messages.values():
            if message.include_in_scene_serialization:
                serializer._insert_message(message)
        return base64.b64encode(serializer.serialize()).decode("ascii")


def client_head() -> str:
    """Return the scripts in the head of viser's client in one text."""
    import viser

    page = (Path(viser.__file__).parent / "client" / "build" / "index.html").read_text(encoding="utf-8")
    start, end = page.find("<script data-p="), page.find("</head>")
    if start < 0 or end < start:
        raise InputError("the client of viser has an unknown form; reinstall it: pip install 'viser==1.1.*'")
    return page[start:end]


def printable(text: str) -> str:
    """Return the text with "?" for halves of surrogate pairs, which no file can hold."""
    return text.encode("utf-8", "replace").decode("utf-8")
