"""Model files that are refused at once, and with which words."""

import json
import os

import numpy as np
import pytest

from mbsd3d import System

FORMS = (".json", ".toml")


def huge(path, form):
    """200 MB of brackets, of which nothing is read."""
    with path.open("wb") as handle:
        for _ in range(200):
            handle.write(b"[" * 1_000_000)


def text(content):
    """A file of a text."""
    return lambda path, form: path.write_text(content if form == ".json" else f"a = {content}")


def numbers(path, form):
    """As many numbers as fit, in a table."""
    limit = 15_000_000 if form == ".json" else 900_000
    data = {"format": "mbsd3d system", "version": 2, "gravity": [1] * (limit // 3), "bodies": []}
    content = json.dumps(data)
    path.write_text(content if form == ".json" else f"gravity = [{'1, ' * (limit // 3)}]")


def deep_signal(path, form):
    """A signal that is made of signals, 900 levels deep."""
    signal = '{"type": "Scaled", "factor": 1, "signal": ' * 900 + "1" + "}" * 900
    data = {"format": "mbsd3d system", "version": 2, "gravity": [0, 0, 0], "bodies": [], "joints": []}
    driver = '{"type": "SpeedDriver", "a": "ground", "b": "ground", "axis": [0, 0, 1], "speed": ' + signal + "}"
    content = json.dumps(data).replace('"joints": []', f'"joints": [{driver}]')
    toml = 'format = "mbsd3d system"\nversion = 2\ngravity = [0, 0, 0]\nbodies = []\njoints = [' + driver + "]"
    path.write_text(content if form == ".json" else toml.replace(": ", " = ").replace('"type"', "type"))


HOSTILE = {
    "deep signal": (deep_signal, "is nested too deep"),
    "200 MB of nesting": (huge, "has 200000000 bytes; a model file has at most"),
    "nesting": (text("[" * 900_000), "is nested too deep"),
    "closed nesting": (text("[" * 450_000 + "]" * 450_000), "is nested too deep"),
    "objects": (text('{"a":' * 150_000), "nested too deep|line 1"),
    "many numbers": (numbers, "Expected `array` of length <= 3 - at `.*gravity|is no mbsd3d system"),
    "many keys": (
        text('{"a":1,' + ",".join(f'"k{i}":1' for i in range(90_000)) + ',"k89999":1}'),
        "appears twice|line 1",
    ),
    "a long number": (text("1" * 900_000), "Exceeds the limit"),
    "dots": (text("1\na" + ".a" * 450_000 + " = 1"), "more than 32 dots|line 2"),
    "hidden dots": (text("1\nb = {\"=\" = '1', a" + ' ."," . a' * 90_000 + " = 1}"), "more than 32 dots|line 2"),
    "dots after a comment": (text("1 # it's\n[a" + ".a" * 450_000 + "]"), "more than 32 dots|line 1"),
    "open quote": (text('"' + '\\"' * 450_000), "line 1|Unterminated string"),
    "tables": (text("1\n" + "".join(f"[b{i}]\n" for i in range(70_000))), "is no mbsd3d system|line 2"),
    "spaces": (text(" " * 900_000), "is empty|Expecting|Invalid value"),
    "not UTF-8": (lambda path, form: path.write_bytes(b'{"a": "\xff"}'), "is not UTF-8 text .line 1."),
    "UTF-16": (lambda path, form: path.write_bytes("{}".encode("utf-16")), "is not UTF-8 text"),
    "empty": (lambda path, form: path.write_bytes(b" \n"), "is empty"),
    "folder": (lambda path, form: path.mkdir(), "is a folder or a device"),
    "pipe": (lambda path, form: os.mkfifo(path), "is a folder or a device"),
    "device": (lambda path, form: path.symlink_to("/dev/zero"), "is a folder or a device"),
    "missing": (lambda path, form: None, "cannot be read: No such file"),
    "a solution": (lambda path, form: np.savez(path.open("wb"), t=np.zeros(3)), "is not UTF-8 text"),
    "a list": (text("[]"), "is no mbsd3d system"),
    "a number": (text("1"), "is no mbsd3d system"),
    "lone surrogate": (text('{"format": "\\ud800"}'), "is no mbsd3d system|line 1"),
}


def check_refused(folder, case, form):
    """A file of a form that is no model is refused in its words."""
    make, message = HOSTILE[case]
    make(folder / f"model{form}", form)
    with pytest.raises(ValueError, match=rf"model{form}'(?s:.*)({message})"):
        System.from_file(folder / f"model{form}")
