"""The command line: demos, checking and running models, warming up. Nothing heavy is imported before it is needed."""

import math
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import metadata
from pathlib import Path
from typing import Any

import click

from .errors import Mbsd3dError

GROUP = "mbsd3d.commands"
INTERRUPTED = 130  # what a shell gives a program that Ctrl-C ended


class Failure(click.ClickException):
    """An error the user can do something about: one line on stderr, exit code 2."""

    exit_code = 2

    def show(self, file: Any = None) -> None:
        """One line."""
        click.echo(f"mbsd3d: {' '.join(self.message.split())}", err=True)


class Commands(click.Group):
    """The own commands and those of other packages (entry points ``mbsd3d.commands``), with errors in one line."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Own commands, then those of other packages."""
        own = super().list_commands(ctx)
        return own + sorted({entry.name for entry in metadata.entry_points(group=GROUP)} - set(own))

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        """A command by its name; one that cannot be loaded says so when it is listed or called."""
        own = super().get_command(ctx, name)
        if own is not None:
            return own
        for entry in metadata.entry_points(group=GROUP):
            if entry.name == name:
                return command_of(entry)
        return None

    def invoke(self, ctx: click.Context) -> Any:
        """Run a command; expected errors become a `Failure`, Ctrl-C a quiet end."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            click.echo("mbsd3d: interrupted", err=True)
            raise click.exceptions.Exit(INTERRUPTED) from None
        except BrokenPipeError:
            raise  # the reader of a pipe has gone: click ends quietly
        except OSError as error:
            where = f"'{error.filename}': " if error.filename else ""
            raise Failure(f"{where}{error.strerror or error}") from error
        except (ValueError, Mbsd3dError) as error:
            raise Failure(str(error)) from error


def command_of(entry: metadata.EntryPoint) -> click.Command:
    """The command of an entry point, or one that stands for it and says why it cannot be loaded."""
    from .demos.base import load_entry

    try:
        return load_entry(entry, click.Command)
    except ValueError as error:
        reason = str(error)

    def fail(arguments: tuple[str, ...]) -> None:
        raise Failure(f"command '{entry.name}' of {reason}")

    rest = click.Argument(["arguments"], nargs=-1, type=click.UNPROCESSED)
    settings = {"ignore_unknown_options": True}
    return click.Command(entry.name, settings, fail, [rest], short_help=reason, add_help_option=False)


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"]})
def main() -> None:
    """Spatial multibody dynamics: demos, checks and runs of mechanisms."""


out_option = click.option("--out", default="out", show_default=True, help="Folder for the results; made if missing.")


@main.command()
@click.argument("name", required=False)
@click.option("--all", "everything", is_flag=True, help="Run all demos.")
@click.option("--list", "only_list", is_flag=True, help="List the demos (as without arguments).")
@out_option
def demo(name: str | None, everything: bool, only_list: bool, out: str) -> None:
    """Show an effect that exists only in space.

    Prints computed numbers beside their theory; figure and data go to --out.
    """
    from .demos.base import discover
    from .demos.report import listing, report, write

    demos = discover()
    for broken, reason in demos.broken.items():
        click.echo(f"mbsd3d: demo '{broken}' of {reason}", err=True)
    key = name and name.replace("-", "_")
    if key and (everything or only_list):
        raise Failure(f"a name ('{name}') and --all or --list exclude each other; give one")
    if key and key not in demos:
        raise Failure(f"there is no demo '{name}'; there are {', '.join(demos)}")
    if only_list or not (key or everything):
        width = max(map(len, demos))
        click.echo("\n".join(f"{demo.name:{width}}  {demo.title}" for demo in demos.values()))
        return
    folder, failed = ready_folder(out), []
    for shown in demos.values() if everything else [demos[key]]:
        outcome = shown.run()
        click.echo(report(shown, outcome))
        click.echo(f"{listing(write(shown, outcome, folder))}\n")
        failed += [] if outcome.passed else [shown.name]
    if failed:
        click.echo(f"mbsd3d: theory is not met by {', '.join(failed)}", err=True)
        raise click.exceptions.Exit(1)


drop_option = click.option(
    "--drop", multiple=True, metavar="KIND", help="Leave out what cannot be imported (.xml, .urdf), e.g. contact."
)


@main.command()
@click.argument("file")
@drop_option
def check(file: str, drop: tuple[str, ...]) -> None:
    """Find the freedoms and redundant joints of a mechanism.

    FILE is a model file (.json, .toml), a model of MuJoCo (.xml) or ROS (.urdf), or a Python file with build(), which
    returns a System. The exit code is 1 if it is locked or cannot close.
    """
    diagnosis = load(file, drop).check()
    click.echo(str(diagnosis))
    if diagnosis.verdict.startswith(("locked", "cannot close")):
        raise click.exceptions.Exit(1)


@main.command()
@click.argument("file")
@click.option("--t-end", type=float, required=True, help="End of the run [s].")
@click.option("--rtol", type=float, default=1e-8, show_default=True, help="Local relative error of a step.")
@click.option("--output", type=int, help="Number of equally spaced samples; without it every step.")
@drop_option
@click.option("--out", default="out", show_default=True, help="Folder for the results, or the name of the .npz file.")
def run(file: str, t_end: float, rtol: float, output: int | None, drop: tuple[str, ...], out: str) -> None:
    """Simulate a mechanism.

    FILE is a model file (.json, .toml), a model of MuJoCo (.xml) or ROS (.urdf), or a Python file with build(), which
    returns a System. Writes a solution (.npz, read by mbsd3d.load), a table (.csv) and a figure of the energies. Ctrl-C
    keeps what was computed. The exit code is 1 if the certificate fails.
    """
    system = load(file, drop)
    named = Path(out).suffix == ".npz"
    folder = ready_folder(str(Path(out).parent) if named else out)
    target = folder / Path(out if named else file).stem
    from .errors import IntegrationError
    from .plots import save_figure
    from .simulation import simulate

    try:
        solution = simulate(system, t_end, rtol=rtol, output=output)
    except IntegrationError as error:
        keep(error.solution, target)
        raise
    if (solution.record.stopped_by or "").startswith("interrupted"):
        click.echo(f"mbsd3d: {solution.record.stopped_by}", err=True)
        keep(solution, target)
        raise click.exceptions.Exit(INTERRUPTED)
    for path in (solution.save(target), solution.to_csv(target), *save_figure(solution.plot("energy"), target)):
        click.echo(str(path))
    click.echo(str(solution.certificate))
    if not solution.certificate.passed:
        raise click.exceptions.Exit(1)


def load(file: str, drop: tuple[str, ...]) -> Any:
    """The System of a file of any kind; what an import did with it goes to stderr."""
    from .sources import load_model

    system, notes = load_model(file, drop)
    for note in notes:
        click.echo(f"mbsd3d: {note}", err=True)
    return system


def keep(solution: Any, target: Path) -> None:
    """Save an unfinished run, if it has samples, whatever keys are pressed meanwhile."""
    if solution is None or not solution.t.size:
        click.echo("nothing was computed")
        return
    with undisturbed():
        path = solution.save(target)
    click.echo(f"{path}: {solution.t.size} samples up to t = {solution.t[-1]:.6g} s")


@contextmanager
def undisturbed() -> Iterator[None]:
    """No Ctrl-C inside."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


@main.command()
def warmup() -> None:
    """Compile all kernels, so that nothing else has to wait."""
    began = time.perf_counter()
    compile_all()
    click.echo(f"all kernels are compiled ({time.perf_counter() - began:.1f} s)")


def compile_all() -> None:
    """Run a pendulum through every method and every check: each kernel is called once."""
    import mbsd3d as m

    arm = m.Body("arm", 1.0, (0.1, 0.2, 0.2), position=(0.5, 0, 0))
    hinge = m.Revolute(m.GROUND, arm, at=(0, 0, 0), axis=(0, 1, 0))
    driver = m.AngleDriver(hinge, m.Ramp(1.0))
    free, driven = m.System([arm], [hinge]), m.System([arm], [hinge, driver])
    free.assemble(measures={m.measures.position(arm, axis=(0, 0, 1)): -0.05})
    free.check()
    for system, method in ((free, m.DOP853()), (free, m.GeneralizedAlpha(1e-3)), (driven, m.Kinematic())):
        stop = m.measures.rate(hinge) > 1e3 if system is free else None
        solution = m.simulate(system, 1e-2, method=method, stop_when=stop)
        str(solution.certificate)
        solution.reaction(hinge)
    m.accelerations(driven).effort(driver)
    m.linearize(free, free.assemble(angles={hinge: 0.5 * math.pi}))  # it hangs


@main.command()
def version() -> None:
    """Print the version."""
    from . import __version__

    click.echo(f"mbsd3d {__version__}")


def ready_folder(out: str) -> Path:
    """The folder, made if missing, after a trial that it can be written: before anything is computed."""
    import tempfile

    folder = Path(out)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        raise Failure(f"--out '{out}' cannot be written: {error.strerror}; give a folder that can") from error
    return folder
