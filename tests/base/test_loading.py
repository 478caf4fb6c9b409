"""Ctrl-C while another package is loaded is Ctrl-C, and no missing package."""

import signal

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
