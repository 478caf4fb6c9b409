"""Evaluate accelerations at many nearby states without recompiling the equations."""

import numpy as np

from ..base.errors import AssemblyError
from ..base.rotations import matrix
from ..dynamics.state_rates import FACTOR_FROM_OTHER_POSE, PROJECTED, project_and_evaluate
from ..equations.at_state import load_state
from ..equations.compiled import Switches, compile_system, set_input, with_own_inputs
from ..equations.tree import build_spanning_tree
from ..mechanism.mechanism import Mechanism
from ..mechanism.state import State
from ..solver.saddle_point import SOLVED


class Rates:
    """Accelerations and rates of internal states for nearby states, at a twentieth of the cost of `accelerations`.

    The state is taken as it is: it must meet the joints, and their rows must stay as independent as there. Inputs keep
    the value they start with until they are set.
    """

    def __init__(self, system: Mechanism, near: State, switches: Switches | None = None) -> None:
        self.compiled = with_own_inputs(compile_system(system, (), switches))
        self.data = self.compiled.data()
        load_state(self.compiled, self.data, near)
        self.tree = build_spanning_tree(self.compiled.model, self.data, None)

    def set(self, name: str, value: float) -> None:
        """Set the inputs of a given name, for all later states."""
        set_input(self.compiled, name, value)

    def __call__(self, state: State) -> tuple[np.ndarray, np.ndarray]:
        """Return accelerations (n, 6) of reference points and angles, world axes, and rates (k,) of z.

        Raises an AssemblyError if the equations have no solution.
        """
        model, n = self.compiled.model, self.compiled.model.body.size
        y = load_state(self.compiled, self.data, state)
        rates = np.empty_like(y)
        done = project_and_evaluate(model, self.data, self.tree, state.t, y, rates, FACTOR_FROM_OTHER_POSE)
        if done != (PROJECTED, SOLVED):
            raise AssemblyError(
                "the equations of motion have no solution here", time=state.t, advice="search near a state that has one"
            )
        a = rates[7 * n : 13 * n].reshape(n, 6).copy()
        a[:, 3:] = np.einsum("nij,nj->ni", matrix(y[: 7 * n].reshape(n, 7)[:, 3:]), a[:, 3:])
        return a, rates[13 * n : 13 * n + model.z_work].copy()
