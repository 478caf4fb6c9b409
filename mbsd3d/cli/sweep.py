"""Command ``mbsd3d sweep``: a mechanism of a Python file over ranges of its parameters."""

from collections.abc import Callable, Sequence
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from ..base.errors import InputError
from .interruption import INTERRUPT_EXIT_CODE
from .run import METHODS, method_of
from .support import Failure, list_parameters, parameters_option, ready_target, undisturbed

if TYPE_CHECKING:
    from numpy import ndarray
    from xarray import Dataset

    from ..api.solution import Solution
    from ..base.figure import Figure

REDUCTIONS = ("max", "min", "mean", "rms", "end")
MEASURE_FORMS = "REDUCTION:QUANTITY[.x|.y|.z][:PART], e.g. max:reaction:main, end:angle:hinge or rms:velocity.z:arm"
LINES_SHOWN = 12  # [1] of the table, on the terminal


class Wanted(NamedTuple):
    """A number that is read from each run."""

    text: str
    reduction: str
    quantity: str
    component: str
    parts: tuple[str, ...]


@click.command(epilog="Example: mbsd3d sweep pendulum.py --set length=0.5:2:16 --measure max:reaction:hinge --t-end 2")
@click.argument("file")
@click.option(
    "--set", "settings", multiple=True, metavar="NAME=VALUES",
    help="Values of a parameter of build(...): FROM:TO:COUNT, a list 1,2,5, or one. Repeatable: every combination.",
)  # fmt: skip
@click.option(
    "--measure", "measures", multiple=True, metavar="NUMBER",
    help="REDUCTION:QUANTITY:PART with max, min, mean, rms or end of what plot draws, e.g. max:reaction:main; vectors "
    "by their length, or one component, e.g. max:position.z:arm. Repeatable. Default: the file's measure(solution).",
)  # fmt: skip
@click.option("--t-end", type=float, default=5.0, show_default=True, help="End of each run [s].")
@click.option("--method", type=click.Choice(METHODS), help="Integration method; default: DOP853.")
@click.option("--dt", type=float, help="Fixed step [s] of the method.")
@click.option("--rtol", type=float, default=1e-8, show_default=True, help="Tolerance: a step may err by a fifth of it.")
@click.option("--output", type=int, default=201, show_default=True, help="Equally spaced samples of each run.")
@click.option(
    "--ledger",
    metavar="FILE",
    help="Keep finished runs in this file; the same command with the same model continues from there.",
)
@parameters_option
@click.option("--out", default="out", show_default=True, help="Folder for the results, or the name of the .csv file.")
def sweep(
    file: str, settings: tuple[str, ...], measures: tuple[str, ...], ledger: str | None, help_parameters: bool,
    out: str, method: str | None, **run: Any,
) -> None:  # fmt: skip
    """Run a mechanism over ranges of its parameters.

    FILE is a Python file with build(), which returns a System. Writes a table (.csv) and, over one or two parameters, a
    figure. Ctrl-C keeps the finished runs. The exit code is 1 if a run fails.
    """
    if help_parameters:
        list_parameters(file)
    wanted = [wanted_of(text) for text in measures]
    run["method"] = method_of(method, run.pop("dt"), None)
    target = ready_target(file, out, ".csv")
    from ..api.model_input import given_values, loaded
    from ..plotting.plots import save_figure
    from ..sweeps.sweep import sweep as run_cells

    with loaded(file) as module:
        build, source = module.build, sha256(Path(file).read_bytes()).hexdigest()
        grid = given_values(build, settings, file)
        if not grid:
            raise Failure("nothing to sweep over; give --set NAME=FROM:TO:COUNT (--help-parameters lists the names)")
        read = (lambda solution: numbers(solution, wanted)) if wanted else own_measure(module, file)
        table = run_cells(build, grid, read, run=run, ledger=ledger, tag=f"{' '.join(measures)}, file {source}")
    if table.attrs["failed"] == table.attrs["cells"]:
        raise Failure(f"all runs failed, the first: {errors_of(table)[0]}")
    with undisturbed():
        path = target.with_name(f"{target.name}.csv" if out.endswith(".csv") else f"{target.name}_sweep.csv")
        table.to_dataframe().to_csv(path)
    click.echo(shown(table))
    click.echo(str(path))
    if (figure := drawn(table)) is not None:
        for written in save_figure(figure, path.with_suffix("")):
            click.echo(str(written))
    finish(table)


def wanted_of(text: str) -> Wanted:
    """Read what --measure asks for."""
    reduction, _, rest = text.partition(":")
    quantity, *parts = rest.split(":")
    name, _, component = quantity.partition(".")
    if reduction not in REDUCTIONS or not name or component not in ("", "x", "y", "z"):
        raise InputError(f"--measure '{text}': give {MEASURE_FORMS}; reductions are {', '.join(REDUCTIONS)}")
    return Wanted(text, reduction, name, component, tuple(parts))


def own_measure(module: Any, file: str) -> Callable[..., Any]:
    """Return the function ``measure`` of a file."""
    found = getattr(module, "measure", None)
    if not callable(found):
        raise InputError(f"nothing to measure; give --measure {MEASURE_FORMS}, or define measure(solution) in '{file}'")
    return found


def numbers(solution: "Solution", wanted: Sequence[Wanted]) -> dict[str, float]:
    """Return the numbers that are asked for of a run, by their texts and what they are of."""
    from ..plotting.panels import panels_of

    found: dict[str, float] = {}
    for one in wanted:
        panels = panels_of(solution, one.quantity, one.parts)
        for panel in panels:
            lines = scalars(panel.lines, one.component)
            if not lines:
                raise InputError(f"--measure {one.text}: {panel.label} has no component {one.component}; leave it out")
            for name, values in lines.items():
                label = " ".join([one.reduction, panel.label, *([name] if name else []), panel.unit])
                found[label] = reduced(values, one.reduction)
    return found


def scalars(lines: "Sequence[tuple[str, ndarray]]", component: str) -> "dict[str, ndarray]":
    """Return series of numbers: one component of a vector, its length, or what is not a vector as it is."""
    import numpy as np

    axes = {name.partition(",")[0]: values for name, values in lines}
    if component:
        return {component: axes[component]} if component in axes else {}
    if set(axes) == {"x", "y", "z"}:
        return {"": np.linalg.norm([*axes.values()], axis=0)}
    return {name if len(lines) > 1 else "": values for name, values in lines}


def reduced(values: "ndarray", reduction: str) -> float:
    """Return one number of a series."""
    import numpy as np

    return float(values[-1] if reduction == "end" else np.sqrt(np.mean(values**2)) if reduction == "rms"
                 else getattr(values, reduction)())  # fmt: skip


def shown(table: "Dataset") -> str:
    """Return the first lines of a table, and how many there are."""
    frame = table.drop_vars("error").to_dataframe()
    rest = len(frame) - LINES_SHOWN
    lines = frame.head(LINES_SHOWN).to_string(float_format=lambda x: f"{x:.6g}")
    return f"{lines}\n... and {rest} more" if rest > 0 else lines


def drawn(table: "Dataset") -> "Figure | None":
    """Return the numbers over one or two parameters; None over more, or of no number."""
    from ..base.figure import Figure
    from ..base.style import LIGHT, figure_style, style_axes

    swept = [name for name in table.dims if table.sizes[name] > 1]
    names = [name for name in table.data_vars if name != "error" and set(table[name].dims) == set(table.dims)]
    if len(swept) not in (1, 2) or not names:
        return None
    with figure_style(LIGHT):
        figure = Figure(figsize=(7.5, 1.0 + 2.5 * len(names)), layout="constrained")
        for axes, name in zip(figure.subplots(len(names), 1, squeeze=False)[:, 0], names, strict=True):
            values = table[name].squeeze(drop=True).transpose(*swept)
            places = [table[dim].values for dim in swept]
            if len(swept) == 1:
                axes.plot(places[0], values, color=LIGHT.colour(0), marker=".")
                axes.set_ylabel("\n".join(str(name).rsplit(" ", 1)) if len(str(name)) > 24 else str(name))
            else:
                image = axes.pcolormesh(*places, values.T, shading="nearest")
                figure.colorbar(image, ax=axes, label=str(name))
                axes.set_ylabel(str(swept[1]))
            axes.set_xlabel(str(swept[0]))
            style_axes(axes, LIGHT)
    return figure


def errors_of(table: "Dataset") -> list[str]:
    """Return the errors of the runs that failed."""
    return [text for text in table["error"].values.ravel() if text]


def finish(table: "Dataset") -> None:
    """End with 1 if a run failed, as after Ctrl-C if the sweep was stopped."""
    if table.attrs["stopped_by"]:
        click.echo(f"mbsd3d: {table.attrs['stopped_by']}", err=True)
        raise click.exceptions.Exit(INTERRUPT_EXIT_CODE)
    if errors := errors_of(table):
        click.echo(f"mbsd3d: {len(errors)} of {table.attrs['cells']} runs failed, the first: {errors[0]}", err=True)
        raise click.exceptions.Exit(1)
