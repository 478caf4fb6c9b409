"""``mbsd3d validate``: a model of the user's, or every case, against other engines and closed forms."""

from typing import Any

import click

ENGINES = ("mujoco", "exudyn", "definitions")  # of crosscheck.check, which is imported when it is needed
OF_SUITE = ("quick", "names", "only_list", "fresh", "out")
"""Options of the suite of all cases; the others are those of MODEL."""


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
@click.option("--quick", is_flag=True, help="Cases: the short list, in less than a minute.")
@click.option("--case", "names", multiple=True, metavar="NAME", help="Cases: only this one; may be repeated.")
@click.option("--list", "only_list", is_flag=True, help="Cases: name them and end.")
@click.option("--fresh", is_flag=True, help="Cases: forget what an interrupted run has left.")
@click.option("--out", help="Cases: folder for the report, made if missing.  [default: out/validation]")
def validate(model: str | None, **options: Any) -> None:
    """Compare MODEL with MuJoCo and Exudyn, or without one: every case.

    MODEL is a model file (.json, .toml), a model of MuJoCo (.xml) or ROS (.urdf), or a Python file with build(), which
    returns a System. Mass matrix, accelerations, motion, energies, momenta and reactions are compared, each engine at
    ever shorter steps. The exit code is 1 if anything differs without a proven cause, or if no engine could compare.
    The engines: pip install 'mbsd3d[validation]'.

    Without MODEL all cases are compared with theory, the planar solver, their definitions and the engines; the report
    is a page (.html) and its numbers (.json). A run that was killed goes on with the same command. The exit code is 1
    if anything differs without a proven cause.
    """
    given = {name: value for name, value in options.items() if value not in (None, (), False)}
    wrong = [name for name in given if (name in OF_SUITE) == (model is not None)]
    if wrong:
        option = next(x.opts[0] for x in click.get_current_context().command.params if x.name == wrong[0])
        raise ValueError(f"{option} is for {'all cases, without' if model else 'a'} MODEL; leave out one of both")
    if model is None:
        from validation.suite.cli import validate_all

        validate_all(**given)
        return
    from validation.crosscheck.command import validate_model

    validate_model(model, **given)
