"""``mbsd3d bicycle``: the studies of bicycles."""

import click


@click.group()
def bicycle() -> None:
    """Stability, sensitivity, rides and circles of bicycles with ideal wheels."""
