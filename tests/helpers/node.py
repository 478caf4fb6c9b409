"""Scripts of pages run in node, without a browser."""

import json
import shutil
import subprocess
from importlib.resources import files
from typing import Any

import pytest


def run_in_node(assets: tuple[str, ...], script: str, given: Any) -> Any:
    """What `script` puts into ``found``, after the scripts of a page of these names; it reads ``given``."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("no node on PATH: install it (Debian: apt install nodejs)")
    folder = files("mbsd3d") / "view" / "page" / "assets"
    before = "let found; const given = JSON.parse(require('fs').readFileSync(0, 'utf-8'));\n"
    after = "\nprocess.stdout.write(JSON.stringify(found));"
    text = "\n".join([(folder / name).read_text(encoding="utf-8") for name in assets])
    done = subprocess.run(
        [node, "-e", f'"use strict";\n{text}\n{before}{script}{after}'], input=json.dumps(given), capture_output=True,
        text=True, timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-3000:]
    return json.loads(done.stdout)
