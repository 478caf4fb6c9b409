"""Command ``mbsd3d gallery``: all demos as a site of pages that need no network."""

import time

import click

from ..base.wording import counted
from .support import Failure, can_view, ready_folder

# [1] processes; a demo keeps a core busy, and more would share the caches of the first compilation
GALLERY_PROCESSES = 2


@click.command(epilog="Example: mbsd3d gallery dzhanibekov tippe_top --out gallery")
@click.argument("names", nargs=-1)
@click.option("--out", default="site", show_default=True, help="Folder of the site; made if missing.")
def gallery(names: tuple[str, ...], out: str) -> None:
    """Build the gallery of all demos (or of NAMES) as static pages.

    Pages that have not changed since the last call are kept.
    """
    from concurrent.futures import as_completed

    from ..demos.discovery import discover
    from ..demos.gallery import front, page
    from .workers import working

    can_view(needed=True)
    demos = discover()
    wanted = [demos.find(name).name for name in names] or list(demos)
    folder, began, lost = ready_folder(out), time.perf_counter(), []
    index = front(list(demos), folder)  # what is there can be read while the rest is made, and after an interruption
    with working(GALLERY_PROCESSES) as pool:
        tasks = {pool.submit(page, name, folder): name for name in wanted}
        for k, task in enumerate(as_completed(tasks)):
            name, error = tasks[task], task.exception()
            lost += [f"{name}: {error}"] if error else []
            state = f"FAILED: {error}" if error else "done" if task.result() else "as it was"
            if not error and task.result():
                front(list(demos), folder)
            click.echo(f"mbsd3d: page {k + 1} of {len(wanted)}, {name}: {state}", err=True)
    size = sum(path.stat().st_size for path in folder.iterdir()) / 1e6
    click.echo(
        f"{index}: {counted(len(wanted) - len(lost), 'page')}, {size:.0f} MB, {time.perf_counter() - began:.0f} s"
    )
    if lost:
        raise Failure("; ".join(lost))
