"""Kernels that the helper process of the first run compiles: see `compiler.first_run`."""

import numpy as np
from numba import typeof

from ..compiler.numba_private import Dispatcher
from ..equations.compiled import compile_system
from ..equations.tree import build_spanning_tree
from ..integrators.dop853 import DOP853
from ..integrators.memory import allocate_run
from ..mechanism.bodies import Body
from ..mechanism.mechanism import Mechanism


def compile_loop() -> None:
    """Compile the loop of the default method, by the types of what it is called with."""
    compiled, method = compile_system(Mechanism([Body("body", 1.0, (0.1, 0.2, 0.25))])), DOP853()
    model, data = compiled.model, compiled.data()
    memory = allocate_run(np.zeros(13), 1, np.zeros(0), 1, 1, method.dense_terms)
    given = model, data, build_spanning_tree(model, data), method.start(model, compiled.data), memory, 1
    if isinstance(method.loop, Dispatcher):  # else kernels run as plain Python
        method.loop.compile(tuple(map(typeof, given)))
