"""Common parts of the commands: errors in one line, commands of other packages, models, folders, unfinished runs."""

import signal
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click

from ..base.errors import CONTROL_CHARACTERS
from ..base.progress import Heartbeat
from ..base.version import load_entry
from ..base.wording import counted
from .interruption import INTERRUPT_EXIT_CODE, INTERRUPT_MESSAGE, answered_at_once, end_now

if TYPE_CHECKING:
    from ..api.solution import Solution
    from ..api.system import System
    from ..mechanism.state import State
    from ..view.page.served import Served

SHORT_HELP_MAX = 500  # [characters] of a first sentence in a list of commands: all of them
GROUP = "mbsd3d.commands"
IMPORT_ERRORS = (ImportError, AttributeError, SystemError)
"""What a library makes of Ctrl-C while it is being loaded."""


out_option = click.option("--out", default="out", show_default=True, help="Folder for the results; made if missing.")
READING = "mbsd3d.reading"
"""Key under which a command keeps how an imported model is read."""


def keep_reading(ctx: click.Context, option: click.Parameter, value: Any) -> None:
    """Keep an option of the import for `load_posed`."""
    ctx.meta.setdefault(READING, {})[option.name] = value


def import_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options of imported models to a command, which itself is given ``drop`` only."""
    for option in (
        click.option(
            "--package-path", "package_paths", multiple=True, metavar="FOLDER", expose_value=False,
            callback=keep_reading, help="Folder in which packages and meshes of an imported model lie. Repeatable.",
        ),
        click.option(
            "--floating/--fixed", default=None, expose_value=False, callback=keep_reading,
            help="Whether the root of a robot (.urdf, .xacro, .sdf) can move; default: as the file suggests.",
        ),
        click.option(
            "--limits", type=click.Choice(["watched", "stop"]), expose_value=False, callback=keep_reading,
            help="Limits of joints of an imported model: watched (default), or a stop for each.",
        ),
        click.option(
            "--leave-out", "--drop", "drop", multiple=True, metavar="KIND,...",
            help="Leave out parts that act and cannot be imported (.xml, .urdf, .sdf, ...), e.g. fluid,tendon.",
        ),
    ):  # fmt: skip
        command = option(command)
    return command


pose_option = click.option("--pose", metavar="NAME", help="Start at this key frame (.xml) or state (.sdf) of a model.")


class Failure(click.ClickException):
    """Error that the user can correct: one line on stderr, exit code 2."""

    exit_code = 2

    def show(self, file: Any = None) -> None:
        """Print one line; a "?" replaces each control character that a file or a path may bring in."""
        line = CONTROL_CHARACTERS.sub("?", " ".join(self.message.split()))
        click.echo(f"mbsd3d: {line}", err=True)


class Listed(click.Group):
    """A group whose help lists its commands with their whole first sentence."""

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the names of the commands and what each does, over several lines where one is too short."""
        found = [(name, self.listed(ctx, name)) for name in self.list_commands(ctx)]
        with formatter.section("Commands"):
            formatter.write_dl(
                [(name, command.get_short_help_str(SHORT_HELP_MAX)) for name, command in found if command]
            )

    def listed(self, ctx: click.Context, name: str) -> click.Command | None:
        """Return what stands for a command in the list: the command, or one with its help alone."""
        return self.get_command(ctx, name)


class Commands(Listed):
    """Built-in commands and those of other packages (entry points ``mbsd3d.commands``), with errors in one line."""

    def __call__(self, *args: Any, **given: Any) -> Any:
        """Run the command line as a process; after Ctrl-C it ends without the cleanup of Python, which takes
        longest."""
        try:
            return super().__call__(*args, **given)
        except SystemExit as end:
            if end.code == INTERRUPT_EXIT_CODE:
                end_now()
            raise

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return built-in commands, then those of other packages."""
        own = super().list_commands(ctx)
        return own + sorted({entry.name for entry in metadata.entry_points(group=GROUP)} - set(own))

    def get_command(self, ctx: click.Context, name: str) -> click.Command | None:
        """Return a command by its name; one that cannot be loaded says so when it is listed or called."""
        own = super().get_command(ctx, name)
        if own is not None:
            return own
        for entry in metadata.entry_points(group=GROUP):
            if entry.name == name:
                return command_of(entry)
        return None

    def resolve_command(self, ctx: click.Context, args: list[str]) -> tuple[Any, ...]:
        """Find the command that is called; raise `Failure` for an option of one value that is given twice."""
        name, command, rest = super().resolve_command(ctx, args)
        if command is not None:
            check_given_once(command, ctx, rest)
        return name, command, rest

    def invoke(self, ctx: click.Context) -> Any:
        """Run a command; expected errors become a `Failure`, Ctrl-C a quiet end."""
        try:
            with answered_at_once() as came, Heartbeat(lambda: ctx.invoked_subcommand or "start"):
                try:
                    return super().invoke(ctx)
                except Exception as error:
                    if came.is_set() and isinstance(error.__cause__ or error, IMPORT_ERRORS):
                        raise KeyboardInterrupt from None
                    raise
        except KeyboardInterrupt:
            click.echo(INTERRUPT_MESSAGE, err=True)
            raise click.exceptions.Exit(INTERRUPT_EXIT_CODE) from None
        except BrokenPipeError:
            raise  # the reader of a pipe has gone: click ends quietly
        except OSError as error:
            where = f"'{error.filename}': " if error.filename else ""
            raise Failure(f"{where}{error.strerror or error}") from error
        except ValueError as error:
            raise Failure(str(error)) from error


def check_given_once(command: click.Command, parent: click.Context, args: list[str]) -> None:
    """Raise a `Failure` for an option of one value that a command, or one of its own commands, is given twice.

    click takes the last one without a word.
    """
    ctx = click.Context(command, parent, command.name, **command.context_settings)
    _, rest, order = command.make_parser(ctx).parse_args(list(args))
    for option in order:
        single = isinstance(option, click.Option) and not (option.is_flag or option.multiple or option.count)
        if single and order.count(option) > 1:
            raise Failure(f"{option.opts[0]} is given twice; give it once")
    inner = command.get_command(ctx, rest[0]) if isinstance(command, click.Group) and rest else None
    if inner is not None:
        check_given_once(inner, ctx, rest[1:])


def command_of(entry: metadata.EntryPoint) -> click.Command:
    """Return the command of an entry point, or a substitute that says why it cannot be loaded."""
    try:
        return load_entry(entry, click.Command)
    except ValueError as error:
        reason = str(error)

    def fail(arguments: tuple[str, ...]) -> None:
        raise Failure(f"command '{entry.name}' of {reason}")

    rest = click.Argument(["arguments"], nargs=-1, type=click.UNPROCESSED)
    settings = {"ignore_unknown_options": True}
    return click.Command(entry.name, settings, fail, [rest], short_help=reason, add_help_option=False)


set_option = click.option(
    "--set", "settings", multiple=True, metavar="NAME=VALUE", help="A parameter of build(...) of a Python file."
)
parameters_option = click.option(
    "--help-parameters", is_flag=True, help="List the parameters of build(...) of a Python file and exit."
)


def list_parameters(file: str) -> NoReturn:
    """List the parameters of build(...) of a Python file and exit."""
    from ..api.model_input import parameters_of

    click.echo("\n".join(parameters_of(file)) or "no parameters")
    raise click.exceptions.Exit(0)


def load_system(
    file: str, drop: tuple[str, ...], settings: tuple[str, ...] = (), show: bool = False, inputs: bool = False
) -> "System":
    """Load the System of a file of any kind; messages of an import go to stderr. ``show``: list parameters and end."""
    if show:
        list_parameters(file)
    return load_posed(file, drop, settings, None, inputs)[0]


def load_posed(
    file: str, drop: tuple[str, ...], settings: tuple[str, ...], pose: str | None, inputs: bool = False
) -> tuple["System", "State | None"]:
    """Load the System of a file, and the state of the key frame that ``pose`` names.

    ``inputs``: motors and servos of an imported model become inputs.
    """
    from ..api.model_input import load_model

    context = click.get_current_context(silent=True)
    reading = {} if context is None else context.meta.get(READING, {})
    found = load_model(file, drop, settings, inputs=inputs, **reading)
    for note in found.notes:
        click.echo(f"mbsd3d: {note}", err=True)
    if pose is not None and pose not in found.states:
        have = ", ".join(found.states) or "none"
        raise Failure(f"--pose {pose}: '{file}' has no such key frame; there are {have}")
    return found.system, None if pose is None else found.states[pose]


def ready_folder(out: str, option: str = "--out") -> Path:
    """Return the folder, created if missing, after a trial that it can be written: before anything is computed."""
    folder = Path(out)
    if folder.exists() and not folder.is_dir():
        raise Failure(f"{option} '{out}' is a file; give a folder")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        raise Failure(f"{option} '{out}' cannot be written: {error.strerror}; give one that can") from error
    return folder


def ready_target(file: str, out: str, suffix: str) -> Path:
    """Return the target of results, without suffix: --out is a folder, which gets the name of the model, or a file's
    name.
    """
    named = Path(out).suffix == suffix
    folder = ready_folder(str(Path(out).parent) if named else out)
    return folder / Path(out if named else file).stem


def can_view(needed: bool = False) -> bool:
    """Return whether pages can be made; a missing package is reported in one line, and is a failure if one is
    needed."""
    from ..view.page.recorder import import_viser

    try:
        import_viser("a view")
    except ValueError as error:
        if needed:
            raise
        click.echo(f"mbsd3d: {error}", err=True)
        return False
    return True


def watch(view: "Served") -> None:
    """Print the address of the server, open a browser if possible, and wait for Ctrl-C."""
    if Heartbeat.on is not None:
        Heartbeat.on.end()
    with view, suppress(KeyboardInterrupt):
        click.echo(f"{view.url}  (Ctrl-C ends it)")
        if view.can_open():
            view.open()
        view.wait()


def keep(solution: "Solution | None", target: Path) -> None:
    """Save an unfinished run, if it has samples, whatever keys are pressed meanwhile."""
    if solution is None or not solution.t.size:
        click.echo("nothing was computed")
        return
    with undisturbed():
        path = solution.save(target)
    click.echo(f"{path}: {counted(solution.t.size, 'sample')} up to t = {solution.t[-1]:.6g} s")


@contextmanager
def undisturbed() -> Iterator[None]:
    """Ignore Ctrl-C within the block."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
