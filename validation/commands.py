"""``mbsd3d validate``: a model of the user's, or every case, against other engines and closed forms."""

from typing import Any

import click

ENGINES = ("mujoco", "exudyn", "definitions")  # of crosscheck.check, which is imported when it is needed


@click.command()
@click.argument("model", required=False)
@click.option("--t-end", type=float, help="MODEL: end of the comparison [s].  [default: 1]")
@click.option(
    "--engine", "engines", multiple=True, type=click.Choice(ENGINES),
    help="MODEL: compare with this one only; may be given more than once.  [default: all]",
)  # fmt: skip
@click.option("--tolerance", type=float, help="MODEL: relative difference that counts as agreement.  [default: 1e-6]")
@click.option("--budget", type=float, help="MODEL: seconds for the runs of an engine.  [default: 10]")
@click.option("--json", "json_file", type=click.Path(), metavar="FILE", help="MODEL: write the findings there.")
@click.option("--html", "html_file", type=click.Path(), metavar="FILE", help="MODEL: write a page there (offline).")
@click.option(
    "--drop",
    multiple=True,
    metavar="KIND",
    help="MODEL: leave out what cannot be imported (.xml, .urdf), e.g. contact.",
)
def validate(model: str | None, **options: Any) -> None:
    """Compare MODEL with MuJoCo and Exudyn, or without one: every case.

    MODEL is a model file (.json, .toml), a model of MuJoCo (.xml) or ROS (.urdf), or a Python file with build(), which
    returns a System. Mass matrix, accelerations, motion, energies, momenta and reactions are compared, each engine at
    ever shorter steps. The exit code is 1 if anything differs without a proven cause, or if no engine could compare.
    The engines: pip install 'mbsd3d[validation]'.
    """
    if model is None:
        raise NotImplementedError
    from .crosscheck.command import validate_model

    given = {name: value for name, value in options.items() if value not in (None, ())}
    validate_model(model, **given)
