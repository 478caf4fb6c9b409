"""``mbsd3d validate``: a model of the user's, or every case, against other engines and closed forms."""

import click


@click.command()
@click.argument("model", required=False)
@click.option("--quick", is_flag=True, help="Without MODEL: the short list, in less than a minute.")
@click.option("--case", "names", multiple=True, metavar="NAME", help="Without MODEL: only this case; may be repeated.")
@click.option("--list", "only_list", is_flag=True, help="Without MODEL: list the cases.")
@click.option("--fresh", is_flag=True, help="Without MODEL: forget what an earlier run has left.")
@click.option("--out", default="out/validation", show_default=True, help="Folder for the report; made if missing.")
def validate(
    model: str | None, quick: bool, names: tuple[str, ...], only_list: bool, fresh: bool, out: str
) -> None:  # fmt: skip
    """Compare MODEL with MuJoCo and Exudyn, or without one: every case with theory and other engines.

    Writes a page (.html) and its numbers (.json). A run that was killed goes on with the same command. The exit code is
    1 if anything differs.
    """
    from .suite.cli import list_cases, validate_all

    if only_list:
        list_cases(quick)
        return
    validate_all(out, names, quick, fresh)
