"""Parameters of force laws: declared once, packed and read back by name."""

import numba
import numpy as np
import pytest

from mbsd3d.compiler.records import Parameters

LAW = Parameters(stiffness="N/m", axis=("1", 3), length="m")
GIVEN = {"length": 0.3, "stiffness": 7.0, "axis": (0.1, -0.2, 0.4)}
read = LAW.reader()


@numba.njit
def read_twice(numbers, first):
    own = read(numbers, first)
    return own.stiffness, own.axis[0], own.axis[2], own.length


@pytest.mark.parametrize("number", [float, complex])
def test_kernels_read_what_python_packs(number):
    numbers = np.array([9.0, 8.0, *LAW.pack(GIVEN), 6.0], number) * (1.0 if number is float else 1.0 + 2.0j)
    factor = numbers[0] / 9.0
    assert read_twice(numbers, 2) == (7.0 * factor, 0.1 * factor, 0.4 * factor, 0.3 * factor)
    plain = LAW.read_in_python(numbers, 2)
    assert (plain.stiffness, plain.axis[2], plain.length) == (7.0 * factor, 0.4 * factor, 0.3 * factor)


@pytest.mark.parametrize("given", [{"stiffness": 1.0}, {**GIVEN, "damping": 0.1}])
def test_other_names_are_refused(given):
    with pytest.raises(ValueError, match="the law declares"):
        LAW.pack(given)


def test_units_are_declared_once_for_every_law():
    from mbsd3d.extend import ForceElement

    def below(cls):
        return [cls, *(x for sub in cls.__subclasses__() for x in below(sub))]

    for cls in below(ForceElement):
        assert all(unit for unit in cls.law_parameters.units.values()), cls
