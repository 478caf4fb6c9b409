"""Arguments that the studies share on the command line."""

from typing import Any

import click


def bicycle_argument(function: Any) -> Any:
    """``[BICYCLE] [--unphysical]``: the command gets ``parameters``, a `bicycle.Parameters`."""
    from functools import wraps

    @wraps(function)
    def with_parameters(bicycle: str, unphysical: bool, **rest: Any) -> Any:
        from .parameters import find

        return function(parameters=find(bicycle, unphysical=unphysical), **rest)

    flag = click.option("--unphysical", is_flag=True, help="Accept inertias that no body has; some sets have them.")
    return click.argument("bicycle", default="Meijaard2007")(flag(with_parameters))


out_option = click.option(
    "--out",
    default="out",
    show_default=True,
    help="Folder for the results; made if missing; files of the same name are replaced.",
)
