"""Interface of an integration method."""

from collections.abc import Callable
from typing import Protocol, runtime_checkable

import numpy as np

from ..base.checks import number
from ..base.errors import ChecksArguments
from ..kernels.layout import Data, Model


def check_max_step(step: float, method: str) -> None:
    """Raise an InputError for a longest step that is neither a time above zero nor infinite."""
    if not (isinstance(step, float) and step == np.inf):
        number(step, f"{method}: max_step", positive=True)


class ExplainedProtocol(ChecksArguments, type(Protocol)):  # type: ignore[misc]  # its name is private
    """Metaclass of a protocol whose errors for wrong calls quote the public names of its methods."""


@runtime_checkable
class Method(Protocol, metaclass=ExplainedProtocol):
    """A method of integration: frozen settings, and a compiled loop with a memory of its own.

    A new method is one file: a frozen dataclass derived from this class, and its loop.
    """

    order: int
    """Of the error over a run; 0: nothing is integrated, the poses follow from the drivers."""
    dt: float | None
    """Fixed step [s]; None = adaptive."""
    max_step: float = np.inf
    """Longest step [s]."""
    rho: float = 1.0
    """Factor per step on motions that the step does not resolve; 1 = no numerical damping meant."""
    patience: float = np.inf
    """Steps times bodies that a run may still need where stability limits its step."""
    dense_terms: int = 3
    """Of the dense output: cubic Hermite, and those of its own."""
    loop: Callable
    """Compiled: ``loop(model, data, tree, own, run, budget)`` takes up to ``budget`` steps, returns a status."""

    def start(self, model: Model, data: Callable[[type], Data]) -> tuple | None:
        """Return the memory ``own`` of a run of a model; ``data(dtype)`` makes a work space.

        Raises
        ------
        InputError
            If the method cannot integrate the model.
        """
