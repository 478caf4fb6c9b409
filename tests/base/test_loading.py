"""Ctrl-C while another package is loaded is Ctrl-C, and no missing package."""

import signal
import subprocess
import sys

import pytest

from mbsd3d.extend import loading


def interrupted():
    """What the package meets."""
    signal.raise_signal(signal.SIGINT)


def test_an_import_error_of_ctrl_c_is_ctrl_c():
    with pytest.raises(KeyboardInterrupt), loading():
        try:
            interrupted()
        except KeyboardInterrupt:
            raise ImportError("initialization failed") from None  # as compiled modules do


def test_a_package_cannot_keep_ctrl_c_to_itself():
    with pytest.raises(KeyboardInterrupt), loading():
        try:
            interrupted()
        except BaseException:
            pass


def test_without_ctrl_c_a_missing_package_is_missing():
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(ImportError, match="^no such thing$"), loading():
        raise ImportError("no such thing")
    assert signal.getsignal(signal.SIGINT) is before


FIRST_RUN = """
import sys
from mbsd3d import GROUND, Body, Revolute, System, simulate
bob = Body("bob", 2.0, (0.1, 0.2, 0.15), position=(0.6, 0.1, -0.8))
assert simulate(System([bob], [Revolute(GROUND, bob, at=(0, 0, 0), axis="y")]), 0.1).certificate.passed
print(*sys.modules)
"""


def test_a_first_run_loads_no_package_that_only_few_models_need():
    done = subprocess.run([sys.executable, "-c", FIRST_RUN], capture_output=True, text=True, check=True)
    late = {f"scipy.{name}" for name in ("cluster", "fft", "integrate", "interpolate", "optimize", "signal", "spatial")}
    loaded = {".".join(name.split(".")[:2]) for name in done.stdout.split()}
    assert not loaded & (late | {"matplotlib", "xarray", "viser"})
