"""``mbsd3d validate``: a model of the user's, or every case, against other engines and closed forms."""

import click


@click.command()
@click.argument("model", required=False)
def validate(model: str | None) -> None:
    """Compare MODEL with MuJoCo and Exudyn, or without one: every case."""
    raise NotImplementedError
