"""Parameters of force laws: declared once by name and unit, packed by Python, read by kernels as one record."""

from collections.abc import Callable, Mapping
from typing import Any

import numba
import numpy as np
from numba.extending import intrinsic

from ..base.errors import InputError


class Parameters:
    """The parameters that a force law reads, in the order of their declaration: name -> unit, or (unit, count).

    They stand side by side in ``Model.number``. In a kernel ``own = read(m.number, p.number)``, with ``read`` the
    `reader` bound to a module-level name, gives the record ``own.stiffness``, which costs no more than an index.
    """

    def __init__(self, **units: str | tuple[str, int]) -> None:
        self.counts = {name: 1 if isinstance(unit, str) else unit[1] for name, unit in units.items()}
        self.units = {name: unit if isinstance(unit, str) else unit[0] for name, unit in units.items()}
        self.size = sum(self.counts.values())

    def dtype(self, number: type = float) -> np.dtype:
        """Return the type of the record of real or complex numbers."""
        return np.dtype([(name, number) if k == 1 else (name, number, k) for name, k in self.counts.items()])

    def pack(self, given: Mapping[str, Any]) -> list[float]:
        """Return the numbers in their order; InputError unless exactly the declared names are given."""
        if given.keys() != self.counts.keys():
            raise InputError(
                f"force law: record() gives {sorted(given)}, the law declares {sorted(self.counts)}; give these"
            )
        return [float(x) for name in self.counts for x in np.ravel(given[name])]

    def reader(self) -> Callable:
        """Return the function (array, first) -> record of the parameters from place ``first`` on, for kernels."""
        if numba.config.DISABLE_JIT:
            return self.read_in_python

        def read(typingctx: Any, array: Any, first: Any) -> tuple:
            record = numba.from_dtype(self.dtype(complex if array.dtype == numba.complex128 else float))

            def code(context: Any, builder: Any, signature: Any, args: tuple) -> Any:
                numbers = context.make_array(signature.args[0])(context, builder, args[0]).data
                return builder.bitcast(builder.gep(numbers, [args[1]]), context.get_value_type(record))

            return record(array, first), code

        return intrinsic(read)

    def read_in_python(self, array: np.ndarray, first: int) -> np.record:
        """Return the same record without the compiler."""
        kind = np.dtype((np.record, self.dtype(complex if np.iscomplexobj(array) else float)))
        return array[first : first + self.size].view(kind)[0]
