"""``mbsd3d play``: ranges as texts, refusals in one line, and Ctrl-C ends it in order."""

import re
import signal
import socket
import subprocess
import sys

import pytest
from click.testing import CliRunner

from mbsd3d.cli.play import ranges
from mbsd3d.extend import main

SLED = """
from mbsd3d import Body, Force, Input, System

def build(mass=2.0):
    sled = Body("sled", mass, (0.1, 0.1, 0.1), velocity=(0, 0, 0), omega=(0, 0, 0))
    return System([sled], forces=[Force(sled, (Input("push"), 0, 9.81 * mass))])
"""


@pytest.fixture
def sled(tmp_path):
    """A file with a model."""
    path = tmp_path / "sled.py"
    path.write_text(SLED)
    return str(path)


def test_ranges():
    assert ranges(("motor=-5:5", "a=b=0:1e-3")) == {"motor": (-5.0, 5.0), "a=b": (0.0, 1e-3)}
    for wrong in ("motor", "motor=5", "motor=5:", "=1:2", "motor=a:b", "motor=1:2:3"):
        with pytest.raises(
            ValueError, match=f"--input '{re.escape(wrong)}': give NAME=LOW:HIGH, e.g. --input motor=-5:5"
        ):
            ranges((wrong,))


@pytest.mark.parametrize(
    ("given", "text"),
    [
        (["--input", "psh=-5:5"], "'psh' is not an input of this system, did you mean 'push'? There are 'push'"),
        (["--input", "push=5:-5"], "the range 5 ... -5 is empty or the wrong way round; give low < high"),
        (["--input", "push=1:5"], "input 'push' starts with 0, outside 1 ... 5"),
        (["--input", "push=0:nan"], "input 'push': not finite (nan)"),
        (["--follow", "cart"], "'cart' is not one of the bodies of this system; there are 'sled'"),
        (["--rtol", "-1"], "rtol"),
        (["--set", "weight=3"], "no such parameter"),
    ],
)
def test_what_makes_no_sense_is_said_in_one_line(sled, given, text):
    done = CliRunner().invoke(main, ["play", sled, *given])
    assert done.exit_code == 2 and text in done.output and done.output.count("\n") == 1


def test_a_port_in_use(sled):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        done = CliRunner().invoke(main, ["play", sled, "--port", str(port)])
    assert done.exit_code == 2 and f"port {port} cannot be used" in done.output


@pytest.mark.slow
@pytest.mark.parametrize("arguments", [["play", "{sled}", "--input", "push=-5:5"], ["bicycle", "play"]])
def test_ctrl_c_ends_it(sled, arguments):
    code = "from mbsd3d.cli import main; main(prog_name='mbsd3d')"
    command = [sys.executable, "-c", code, *(text.format(sled=sled) for text in arguments)]
    running = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    said = running.stdout.readline()
    found = re.fullmatch(r"http://127\.0\.0\.1:(\d+)/\?token=\S+  \(Ctrl-C ends it\)\n", said)
    running.send_signal(signal.SIGINT)
    out, errors = running.communicate(timeout=60)
    ended = (0, 130)  # 130 = in the compiler, which a thread of the bicycle may be in just then
    assert found and running.returncode in ended and out == "" and "Traceback" not in errors
    with socket.socket() as probe:
        assert probe.connect_ex(("127.0.0.1", int(found[1]))) != 0
