"""Commands ``mbsd3d bicycle STUDY``: each imports its study when it starts, so that help is quick."""

import ast
from collections.abc import Callable
from functools import wraps
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from mbsd3d.errors import InputError
from mbsd3d.extend import Listed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..parameters import Parameters

STUDIES = {
    "stability": "stability", "sensitivity": "linear", "why": "linear", "ride": "motion", "circles": "motion",
    "frequency": "linear", "rider": "rider", "play": "play", "compare": "linear",
}  # fmt: skip
"""Study -> module here that holds its command, in the order of a course."""


class Studies(Listed):
    """Click group whose commands are imported on demand."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all studies."""
        return [*STUDIES]

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        """Import and return the command of a study."""
        return getattr(import_module(f".{STUDIES[name]}", __name__), name) if name in STUDIES else None

    def listed(self, ctx: click.Context, name: str) -> click.Command:
        """Return a command with the help of a study, read from its source: importing all takes a second."""
        source = Path(__file__).with_name(f"{STUDIES[name]}.py").read_text(encoding="utf-8")
        functions = {node.name: node for node in ast.parse(source).body if isinstance(node, ast.FunctionDef)}
        return click.Command(name, help=ast.get_docstring(functions[name]))


@click.group(cls=Studies)
def bicycle() -> None:
    """Study bicycles: stability, sensitivity, rides and circles, on ideal wheels or on tyres.

    BICYCLE is a name, e.g. Browserins, or a parameter file (.txt, .yml); without it the benchmark bicycle of 2007.
    """


unphysical_option = click.option(
    "--unphysical", is_flag=True, help="Accept inertias that no rigid body has; some sets have them."
)
dark_option = click.option("--dark", is_flag=True, help="Figures on dark paper.")
out_option = click.option(
    "--out",
    default="out",
    show_default=True,
    help="Folder for the results; made if missing; files of the same name are replaced.",
)


def bicycle_argument(function: Callable[..., None]) -> Callable[..., None]:
    """Add ``[BICYCLE] [--unphysical]`` to a command, which gets ``parameters``, a `bicycle.Parameters`."""

    @wraps(function)
    def with_parameters(bicycle: str, unphysical: bool, **rest: Any) -> None:
        from ..parameters import named

        function(parameters=named(bicycle, unphysical=unphysical), **rest)

    return click.argument("bicycle", default="Meijaard2007")(unphysical_option(with_parameters))


OPTION_VALUES = {"none": None, "true": True, "false": False}
"""What stands for something else than a number in ``--tyre KEY=VALUE``."""


def tyre_flags(function: Callable[..., None]) -> Callable[..., None]:
    """Add ``[--tyres] [--tyre KEY=VALUE] [--head K C]`` to a command: ``on_tyres``, ``changed`` and ``head`` for
    `fitted`.
    """
    soft = click.option(
        "--head", type=float, nargs=2, metavar="K C",
        help="Stiffness and damping of a flexible head tube [N m/rad] [N m s/rad], e.g. 2000 2. Implies --tyres.",
    )  # fmt: skip
    several = click.option(
        "--tyre", "changed", multiple=True, metavar="KEY=VALUE",
        help="A parameter of mbsd3d.Tyre, e.g. cornering=12 or mu=0.6; repeatable. Implies --tyres.",
    )  # fmt: skip
    usual = click.option("--tyres", "on_tyres", is_flag=True, help="Use tyres instead of ideal wheels.")
    return usual(several(soft(function)))


def fitted(
    parameters: "Parameters", on_tyres: bool, changed: tuple[str, ...], head: tuple[float, ...] | None
) -> dict[str, Any]:  # fmt: skip
    """Return the arguments of `whipple` for a bicycle by `tyre_flags`; empty = ideal wheels. Published machines have
    their own.
    """
    from ..model.tyres import TYPICAL, both
    from ..parameters import fittings

    found = fittings(parameters)
    if changed or ((on_tyres or head) and not found):
        changes = dict(tyre_number(text) for text in changed)
        found["tyres"] = tuple({**one, **changes} for one in both(found.get("tyres", TYPICAL)))
    if head:
        found |= dict(zip(("head_stiffness", "head_damping"), head, strict=True))
    return found


def tyre_options(function: Callable[..., None]) -> Callable[..., None]:
    """Add ``[--tyres] [--tyre KEY=VALUE] [--head K C]`` to a command: ``fittings`` for `whipple`; empty = ideal
    wheels."""

    @wraps(function)
    def with_fittings(
        parameters: "Parameters", on_tyres: bool, changed: tuple[str, ...], head: tuple[float, ...] | None, **rest: Any
    ) -> None:  # fmt: skip
        function(parameters=parameters, fittings=fitted(parameters, on_tyres, changed, head), **rest)

    return tyre_flags(with_fittings)


def tyre_number(text: str) -> tuple[str, float | bool | None]:
    """Read ``cornering=12`` as a pair; ``mu=none``: unlimited grip; ``camber_lag=false``: a camber force without
    delay."""
    key, _, right = text.partition("=")
    try:
        return key, OPTION_VALUES[right] if right in OPTION_VALUES else float(right)
    except ValueError:
        raise InputError(f"--tyre '{text}': '{right}' is not a number; write e.g. cornering=12") from None


def saved(figure: "Figure", target: Path) -> list[Path]:
    """Write a figure as .png and .svg, and return the paths."""
    from mbsd3d import save_figure

    return save_figure(figure, target)


def report(*paths: Path) -> None:
    """Print the files that were written."""
    for path in paths:
        click.echo(str(path))
