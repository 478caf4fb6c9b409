"""What a browser can be given here: text it can show, and windows."""

import os
import sys
import webbrowser


def has_browser() -> bool:
    """Whether a browser with windows can be opened here."""
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return False
    try:
        webbrowser.get()
    except webbrowser.Error:
        return False
    return True


def printable(text: str) -> str:
    """The text with "?" for what no file can hold (halves of surrogate pairs)."""
    return text.encode("utf-8", "replace").decode("utf-8")
