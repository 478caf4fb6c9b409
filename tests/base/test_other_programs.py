"""Names of other programs lead to those of this one."""

import re

import pytest

import mbsd3d


def test_names_of_other_programs_say_what_they_are_called_here():
    with pytest.raises(ImportError, match="mbsd3d has no 'Weld'; here that is Fixed"):
        from mbsd3d import Weld  # noqa: F401
    with pytest.raises(ImportError, match="'HingeJoint'; here that is Revolute"):
        mbsd3d.HingeJoint  # noqa: B018


def test_what_they_are_called_here_exists():
    for other, own in mbsd3d.lazy.NAMES_ELSEWHERE.items():
        assert other not in mbsd3d.__all__
        for name in re.findall(r"\b[A-Z][a-z]\w+", own):
            assert name in mbsd3d.__all__, other


def test_other_unknown_names_are_plain_attribute_errors():
    with pytest.raises(AttributeError, match="module 'mbsd3d' has no attribute 'nothing'"):
        mbsd3d.nothing  # noqa: B018
    assert not hasattr(mbsd3d, "nothing")
