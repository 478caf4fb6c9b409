"""The command line: what it prints and writes, its exit codes, and one line for everything a user can get wrong."""

import json
import re
import shlex
import signal
import subprocess
import sys
import time
import types
from importlib import metadata

import click
import pytest
from click.testing import CliRunner
from helpers.demo_checks import small
from helpers.scripts import PENDULUM

import mbsd3d
from mbsd3d.cli import interruption
from mbsd3d.cli.interruption import answered_at_once
from mbsd3d.extend import discover, main
from mbsd3d.files import schema
from mbsd3d.integrators.method import Method

DOOR = """
from mbsd3d import GROUND, Body, Revolute, System

def build():
    door = Body("door", 20.0, (8.0, 9.0, 1.5), position=(0.45, 0, 1))
    low = Revolute(GROUND, door, at=(0, 0, 0.2), axis=(0, 0, 1), name="low")
    up = Revolute(GROUND, door, at=(0, 0, 1.8), at_b=({offset}, 0, 1.8), axis=(0, 0, 1), name="up")
    return System([door], [low, up])
"""

BEYOND_REACH = """
from mbsd3d import GROUND, Body, Distance, Prismatic, Ramp, Revolute, SlideDriver, System

def build():
    arm = Body("arm", 1.0, (0.1, 0.1, 0.1), position=(0, 0, 0.5))
    cart = Body("cart", 1.0, (0.1, 0.1, 0.1), position=(1, 0, 0))
    rail = Prismatic(GROUND, cart, at=(1, 0, 0), axis=(1, 0, 0), name="rail")
    joints = [
        Revolute(GROUND, arm, at=(0, 0, 0), axis=(0, 1, 0)),
        rail,
        Distance(arm, cart, at_a=(0, 0, 1), at_b=(1, 0, 0), name="rod"),
        SlideDriver(rail, Ramp(1.0)),
    ]
    return System([arm, cart], joints, gravity=(0, 0, 0))
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty working directory."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def call(*arguments):
    """Run a command in this process; expected errors never show a traceback."""
    result = CliRunner().invoke(main, [str(argument) for argument in arguments], prog_name="mbsd3d")
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    assert "Traceback" not in result.output
    return result


def model(folder, text, name="model.py"):
    """Write a model file; its name."""
    (folder / name).write_text(text)
    return name


def process(*arguments):
    """A process of its own."""
    code = "from mbsd3d.cli import main; main(prog_name='mbsd3d')"
    command = [sys.executable, "-c", code, *map(str, arguments)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def test_help_names_the_commands():
    result = call("--help")
    assert result.exit_code == 0
    for name in ("check", "demo", "run", "show", "version", "warmup"):
        assert re.search(rf"^  {name} ", result.stdout, re.MULTILINE)


def test_all_methods_can_be_chosen():
    """The command line lists them without loading them."""
    known = {name for name, kind in schema.types().items() if Method in kind.__mro__}
    (option,) = (x for x in main.commands["run"].params if x.name == "method")
    assert set(option.type.choices) == known and known <= set(mbsd3d.__all__)


def test_help_needs_click_only():
    code = "import sys; before = set(sys.modules); from mbsd3d.cli import main; main(['--help'], standalone_mode=False)"
    code += "; print(*(set(sys.modules) - before))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    help_text, _, modules = done.stdout.rstrip().rpartition("\n")
    loaded = {name.partition(".")[0] for name in modules.split()}
    assert "Usage: " in help_text
    assert loaded - sys.stdlib_module_names <= {"click", "mbsd3d", "bicycle", "engines", "validation", "__main__"}


def test_version_and_warmup():
    assert call("version").stdout == f"mbsd3d {mbsd3d.__version__}\n"
    assert re.fullmatch(r"all kernels are compiled \(\d+\.\d s\)\n", call("warmup").stdout)


@pytest.mark.parametrize("arguments", [(), ("--list",)])
def test_demos_are_listed_by_family_with_their_questions(arguments):
    lines = call("demo", *arguments).stdout.splitlines()
    families = discover().families()
    assert [line for line in lines if line and not line.startswith(" ")] == [f"{family}:" for family in families]
    shown = [tuple(line.split(maxsplit=1)) for line in lines if line.startswith("  ")]
    assert shown == [(demo.name, demo.question) for demos in families.values() for demo in demos]
    assert len(shown) > 40


def test_a_demo_as_json_is_one_object_and_writes_nothing(folder):
    settings = ("--set", "k=0.3", "--set", "Omega=2")
    result = call("demo", "ball-on-turntable", *settings, "--json")
    found = json.loads(result.stdout)
    assert result.exit_code == 0 and result.stderr == "" and not list(folder.iterdir())
    assert set(found) == {"demo", "parameters", "quantities"} and found["demo"] == "ball_on_turntable"
    assert (found["parameters"]["k"], found["parameters"]["Omega"]) == (0.3, 2.0)
    rate = found["quantities"]["circle_rate_rad_s"]
    assert set(rate) == {"computed", "theory", "error"} and rate["theory"] == pytest.approx(0.6 / 1.3, rel=1e-14)
    assert abs(rate["computed"] - rate["theory"]) == rate["error"] < 1e-9


def test_a_demo_without_a_term_shows_what_is_lost(folder):
    result = call("demo", "dynamic_unbalance", "--without", "gyroscopic", "--json", "--out", "here")
    found = json.loads(result.stdout)
    assert result.exit_code == 0 and found["without"] == "gyroscopic"
    assert abs(found["quantities"]["bearing_force_N"]["computed"]) < 1e-6
    assert (folder / "here" / "dynamic_unbalance_without_gyroscopic.png").exists()


def test_a_demo_without_a_term_differs_as_it_should(folder):
    result = call("demo", "dynamic_unbalance", "--without", "gyroscopic")
    assert result.exit_code == 0 and "differs, as it should" in result.stdout and "FAIL" not in result.stdout


def test_a_demo_prints_its_table_and_writes_figure_and_data(folder):
    result = call("demo", "heavy-top", "--out", "results/today")
    assert result.exit_code == 0
    assert re.search(r"quantity +\| +computed \| +theory \| +error", result.stdout)
    assert re.search(r"^  why ", result.stdout, re.MULTILINE) and re.search(r"^  source ", result.stdout, re.MULTILINE)
    written = {path.name for path in (folder / "results" / "today").iterdir()}
    assert {f"heavy_top{suffix}" for suffix in (".png", ".svg", ".npz", ".csv", ".html")} <= written
    assert "results/today/heavy_top.png" in result.stdout and str(folder) not in result.stdout


def test_without_viser_a_demo_has_no_page_and_says_why(folder, monkeypatch):
    monkeypatch.setitem(sys.modules, "viser", None)
    result = call("demo", "cardan")
    assert result.exit_code == 0 and result.stderr.count("\n") == 1
    assert "a view needs viser 1.1.x, found none; install it: pip install 'viser==1.1.*'" in result.stderr
    assert not list((folder / "out").glob("*.html")) and (folder / "out" / "cardan.png").exists()


@pytest.mark.parametrize("arguments", [("demo", "cardan", "--view"), ("show", "m.py"), ("run", "m.py", "--t-end", 1)])
def test_without_viser_a_view_is_refused_before_anything_is_computed(folder, monkeypatch, arguments):
    monkeypatch.setitem(sys.modules, "viser", None)
    arguments = (*arguments, "--view") if arguments[0] == "run" else arguments
    result = call(*arguments)
    assert result.exit_code == 2 and result.stdout == "" and not list(folder.iterdir())
    assert result.stderr == "mbsd3d: a view needs viser 1.1.x, found none; install it: pip install 'viser==1.1.*'\n"


@pytest.mark.slow
def test_demo_view_says_its_address_and_ends_quietly_with_ctrl_c(folder):
    running = process("demo", "cardan", "--view", "--out", folder)
    lines = []
    for line in running.stdout:
        lines.append(line)
        if "http://" in line:
            break
    assert re.fullmatch(r"http://127\.0\.0\.1:\d+/\?token=[\w-]+  \(Ctrl-C ends it\)\n", lines[-1])
    assert any("quantity" in line for line in lines)
    time.sleep(0.5)
    running.send_signal(signal.SIGINT)
    rest, errors = running.communicate(timeout=60)
    errors = re.sub(r"mbsd3d: \w+: at work for \d+ s\n", "", errors)  # where it took long to start
    assert (rest, errors, running.returncode) == ("", "", 0)


@pytest.mark.parametrize("arguments", [("--view",), ("--all", "--view"), ("--list", "--view")])
def test_demo_view_needs_one_name(folder, arguments):
    result = call("demo", *arguments)
    assert result.exit_code == 2 and result.stderr == "mbsd3d: --view shows one demo; give its name\n"


@pytest.mark.parametrize(("out", "page"), [("out", "out/model.html"), ("here/it.html", "here/it.html")])
def test_show_writes_one_page(folder, out, page):
    result = call("show", model(folder, PENDULUM), "--out", out)
    assert result.exit_code == 0 and result.stdout == f"{page}\n"
    assert [path.name for path in (folder / page).parent.iterdir()] == [(folder / page).name]
    assert "<title>" in (folder / page).read_text()


def test_show_of_a_wrong_file(folder):
    result = call("show", "missing.toml")
    assert result.exit_code == 2 and result.stderr.count("\n") == 1 and "missing.toml" in result.stderr


def test_run_writes_pages_on_request(folder):
    result = call(
        "run", model(folder, PENDULUM), "--t-end", 0.5, "--output", 11, "--view", "--report", "--out", "today/a.npz"
    )
    assert result.exit_code == 0 and "today/a.html\ntoday/a_report.html\n" in result.stdout
    assert (folder / "today" / "a.html").exists() and (folder / "today" / "a_report.html").exists()


def test_run_writes_everything_and_prints_the_certificate(folder):
    result = call("run", model(folder, PENDULUM), "--t-end", 1.0, "--output", 11)
    assert result.exit_code == 0 and "passed: DOP853" in result.stdout
    assert {path.name for path in (folder / "out").iterdir()} == {f"model.{k}" for k in ("npz", "csv", "png", "svg")}
    solution = mbsd3d.load("out/model.npz")
    assert solution.t.size == 11 and solution.t[-1] == 1.0


def test_run_with_a_certificate_that_fails(folder, monkeypatch):
    from mbsd3d.api import simulation

    whole = simulation.simulate
    monkeypatch.setattr(simulation, "simulate", lambda *args, **options: whole(*args, centripetal=False, **options))
    text = PENDULUM.replace("position=(0, 0.6, -0.8)", "com=(0, 0.6, -0.8)")
    result = call("run", model(folder, text), "--t-end", 1.0)
    assert result.exit_code == 1 and "FAILED" in result.stdout and (folder / "out" / "model.npz").exists()


def test_a_run_that_breaks_off_keeps_what_it_has(folder):
    result = call("run", model(folder, BEYOND_REACH), "--t-end", 5.0)
    assert result.exit_code == 2 and len(result.stderr.splitlines()) == 1
    assert re.search(r"^out/model.npz: \d+ samples up to t = ", result.stdout)
    assert 0.1 < mbsd3d.load("out/model.npz").t[-1] < 5.0


INTERRUPTED = """
import os, signal, sys, threading, time
from mbsd3d import simulate

{pendulum}

def interrupt():
    frame = None
    while frame is None:
        time.sleep(0.1)
        frame = sys._current_frames()[threading.main_thread().ident]
        while frame is not None and frame.f_code is not simulate.__code__:
            frame = frame.f_back
    time.sleep(1.0)
    for _ in range(4):  # a hurried hand
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.02)

def build(plain=build):
    simulate(plain(), 0.01)  # then everything is loaded, and Ctrl-C meets the run itself
    threading.Thread(target=interrupt).start()
    return plain()
"""


@pytest.mark.slow
def test_ctrl_c_keeps_what_was_computed(folder):
    """A second after `simulate` was called; the run would take minutes."""
    file = model(folder, INTERRUPTED.format(pendulum=PENDULUM))
    running = process("run", file, "--t-end", 1e6, "--output", 1_000_000, "--out", "kept")
    out, err = running.communicate(timeout=120)
    assert running.returncode == 130 and "interrupted at t = " in err and "Traceback" not in err
    assert re.search(r"^kept/model.npz: \d+ samples up to t = ", out)
    assert mbsd3d.load(folder / "kept" / "model.npz").t.size > 1


def test_a_hurried_hand_presses_ctrl_c_once(monkeypatch):
    pressed = 0
    with answered_at_once():
        for wait in (0.0, 0.0, 0.0, 0.2):
            time.sleep(wait)
            monkeypatch.setattr(interruption, "SECOND_INTERRUPT_SECONDS", 0.1 if wait else 1.0)
            try:
                signal.raise_signal(signal.SIGINT)
            except KeyboardInterrupt:
                pressed += 1
    assert pressed == 2


def test_check_reports_a_redundant_door(folder):
    result = call("check", model(folder, DOOR.replace("{offset}", "0")))
    assert result.exit_code == 0 and "redundant" in result.stdout and "10 rows of rank 5" in result.stdout


@pytest.mark.parametrize(("offset", "verdict"), [("0.001", "locked"), ("0.3", "cannot close")])
def test_check_says_what_cannot_move(folder, offset, verdict):
    result = call("check", model(folder, DOOR.replace("{offset}", offset)))
    assert result.exit_code == 1 and result.stdout.startswith(verdict)


BAD_FILES = {
    "syntax": ("def build(:\n", r"'models/bad.py', line 1: .*; correct the file"),
    "null bytes": ("x = 1\0\n", r"'models/bad.py'.*null bytes"),
    "no build": ("x = 1\n", r"'models/bad.py' has no function build\(\)"),
    "build is a number": ("build = 3\n", r"has no function build\(\)"),
    "returns nothing": ("def build():\n    pass\n", r"build\(\) returned NoneType, not a System"),
    "wants arguments": ("def build(a):\n    pass\n", r"build\(\) needs a; give --set a=VALUE"),
    "fails": ("def build():\n    return 1 / 0\n", r"'models/bad.py', line 2: ZeroDivisionError: division by zero"),
    "missing import": ("import no_such_package\n", r"line 1: ModuleNotFoundError: No module named 'no_such_package'"),
    "leaves": ("import sys\nsys.exit('bye')\n", r"line 2: SystemExit: bye"),
    "bad part": (PENDULUM.replace("mass=1.0", "mass=-1.0"), r"line 5: body 'bob': mass: -1.0 is below 0.0"),
    "open loop": (
        DOOR.replace("{offset}", "0.3").replace("return ", "system = ") + "    system.state()\n    return system\n",
        r"line 9: the reference pose does not close",
    ),
}


@pytest.mark.parametrize("command", [("check",), ("run", "--t-end", "1")])
@pytest.mark.parametrize("kind", BAD_FILES)
def test_a_bad_file_is_one_line(folder, command, kind):
    text, message = BAD_FILES[kind]
    (folder / "models").mkdir()
    result = call(*command, model(folder, text, "models/bad.py"))
    expect_one_line(result, message)
    assert str(folder) not in result.stderr and not (folder / "models" / "__pycache__").exists()


def expect_one_line(result, message):
    """Exit code 2 and one line on stderr that matches."""
    assert result.exit_code == 2
    assert len(result.stderr.splitlines()) == 1 and result.stderr.startswith("mbsd3d: ")
    assert re.search(message, result.stderr), result.stderr


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("check", "absent.py"), "'absent.py': No such file or directory; give a Python file with build"),
        (("check", "."), "'.': give a model"),
        (("run", "absent.py", "--t-end", 1), "'absent.py': No such file"),
        (("run", "model.py", "--t-end", 0), "t_end = 0 s is not later than the start time"),
        (("run", "model.py", "--t-end", "nan"), "t_end: not finite"),
        (("run", "model.py", "--t-end", 1, "--rtol", 2), "rtol 2 is outside"),
        (("run", "model.py", "--t-end", 1, "--output", 1), "output = 1 samples"),
        (("run", "model.py", "--t-end", 1, "--out", "model.py"), "--out 'model.py' is a file; give a folder"),
        (("run", "model.py", "--t-end", 1, "--out", "model.py/x"), "cannot be written: Not a directory"),
        (("demo", "cardan", "--out", "model.py"), "--out 'model.py' is a file; give a folder"),
        (("demo", "unknown"), "there is no demo 'unknown'; see the whole list: mbsd3d demo"),
        (("demo", "falling_dog"), "there is no demo 'falling_dog'; did you mean falling_cat?"),
        (("demo", "stewart", "--set", "yaw=3"), "no parameter 'yaw'; did you mean yaw_deg?"),
        (("demo", "stewart", "--set", "yaw_deg"), "'yaw_deg' is not NAME=VALUE; write e.g. --set Omega=30"),
        (("demo", "stewart", "--set", "yaw_deg=[1]"), "yaw_deg: expected a number"),
        (("demo", "stewart", "--set", "yaw_deg=true"), "yaw_deg = True is not a number"),
        (("demo", "dual_spin", "--set", 'I=["1","2","3"]'), "give 3 finite numbers"),
        (("demo", "stewart", "--set", "yaw_deg=90"), "the six legs leave the platform loose"),
        (("demo", "dual_spin", "--set", "I=[1,2]"), "give 3 finite numbers"),
        (("demo", "stewart", "--without", "giroscopic"), "no term 'giroscopic'; did you mean gyroscopic?"),
        (("demo", "--json"), "--json is for one demo; give its name"),
        (("demo", "cardan", "--all"), "exclude each other"),
        (("demo", "cardan", "--out", "a", "--out=b"), "--out is given twice; give it once"),
        (("nvh", "inline_4", "--car", "compact", "--car", "saloon"), "--car is given twice; give it once"),
        (("bicycle", "stability", "--out", "a", "--out", "b"), "--out is given twice; give it once"),
    ],
)
def test_bad_arguments_are_one_line(folder, arguments, message):
    model(folder, PENDULUM)
    expect_one_line(call(*arguments), message)


def test_a_file_can_import_its_neighbours(folder):
    (folder / "models").mkdir()
    model(folder, "MASS = 3.0\n", "models/masses_of_test.py")
    text = "from masses_of_test import MASS\n" + PENDULUM.replace("mass=1.0", "mass=MASS")
    before = list(sys.path), set(sys.modules)
    assert call("check", model(folder, text, "models/heavy.py")).exit_code == 0
    assert sys.path == before[0] and not {name for name in sys.modules if "heavy" in name} - before[1]


@pytest.fixture
def plugins(monkeypatch):
    """Entry points of another package: a command that works, broken ones, and a demo that fails its theory."""
    module = types.ModuleType("plugin_commands")

    @click.command(short_help="Say hello.")
    def hello():
        click.echo("hello")

    @click.command()
    def refuse():
        raise ValueError("wheel 'front':\n radius is 0")

    module.hello, module.refuse, module.wrong, module.run = hello, refuse, 3, hello
    module.failing = small("failing", "plugin_commands")
    monkeypatch.setitem(sys.modules, "plugin_commands", module)
    names = {"hello": "plugin_commands:hello", "refuse": "plugin_commands:refuse", "wrong": "plugin_commands:wrong",
             "lost": "no_such_package:command", "run": "plugin_commands:run"}  # fmt: skip
    groups = {
        "mbsd3d.commands": [metadata.EntryPoint(name, value, "mbsd3d.commands") for name, value in names.items()],
        "mbsd3d.demos": [
            metadata.EntryPoint("failing", "plugin_commands:failing", "mbsd3d.demos"),
            metadata.EntryPoint("lost", "no_such_package:demo", "mbsd3d.demos"),
        ],
    }
    monkeypatch.setattr(metadata, "entry_points", lambda group: groups.get(group, []))


def test_commands_of_other_packages_join(plugins):
    assert call("hello").stdout == "hello\n"
    listed = call("--help").stdout
    assert re.search(r"^  hello +Say hello.$", listed, re.MULTILINE)
    assert "Simulate a mechanism" in listed  # the own command keeps its name


def test_broken_commands_are_named_in_one_line(plugins, folder):
    listed = " ".join(call("--help").stdout.split())
    assert (
        "ModuleNotFoundError: No module named 'no_such_package'" in listed and "gives an int, not a Command" in listed
    )
    expect_one_line(call("lost", "--any", "thing"), "command 'lost' of .*cannot be loaded: ModuleNotFoundError")
    expect_one_line(call("refuse"), "wheel 'front': radius is 0")


def test_a_demo_that_misses_its_theory_ends_with_1(plugins, folder):
    result = call("demo", "failing")
    assert result.exit_code == 1 and "FAIL, limit 1e-09" in result.stdout
    assert "demo 'lost' of 'no_such_package:demo' cannot be loaded" in result.stderr
    assert result.stderr.splitlines()[-1] == "mbsd3d: theory is not met by failing"


@pytest.mark.parametrize(("meets", "code", "said"), [(True, 130, "mbsd3d: interrupted"), (False, 2, "failed")])
def test_ctrl_c_while_a_library_is_loaded(folder, meets, code, said):
    """Libraries in C answer it by an ImportError of their own."""
    key = "import os, signal, time\ntry:\n    os.kill(os.getpid(), signal.SIGINT)\n    time.sleep(9)\n"
    answer = "except KeyboardInterrupt:\n    raise ImportError('initialization failed')\n"
    (folder / "m.py").write_text(key + answer if meets else "raise ImportError('initialization failed')\n")
    result = CliRunner().invoke(main, ["check", "m.py"])
    assert result.exit_code == code and said in result.stderr.splitlines()[-1]


@pytest.mark.slow
@pytest.mark.parametrize("arguments", [("run", "m.py", "--t-end", "1"), ("warmup",), ("check", "m.py")])
def test_ctrl_c_in_the_compiler_is_a_quiet_end(folder, arguments, monkeypatch):
    (folder / "m.py").write_text(PENDULUM)
    monkeypatch.setenv("MBSD3D_CACHE", str(folder / "empty"))
    running = process(*arguments)
    deadline = time.monotonic() + 60.0
    while not list(folder.rglob("*.code")) and time.monotonic() < deadline:
        time.sleep(0.05)
    running.send_signal(signal.SIGINT)
    _, errors = running.communicate(timeout=60)
    assert running.returncode == 130 and "mbsd3d: interrupted\n" in errors and "Traceback" not in errors
    assert not list(folder.rglob("*.part"))


@pytest.mark.slow
def test_long_commands_say_every_few_seconds_that_they_work(folder, monkeypatch):
    (folder / "m.py").write_text(f"import time\n{PENDULUM}\ntime.sleep(12)\n")
    running = process("check", folder / "m.py")
    _, errors = running.communicate(timeout=120)
    assert running.returncode == 0
    assert 2 <= len(re.findall(r"mbsd3d: (check|start): at work for \d+ s\n", errors)) <= 12


def all_commands(group, path=()):
    context = click.Context(group)
    for name in group.list_commands(context):
        command = group.get_command(context, name)
        yield (*path, name), command
        if isinstance(command, click.Group):
            yield from all_commands(command, (*path, name))


def test_the_help_of_every_command_has_an_example_and_says_whole_sentences():
    for path, command in all_commands(main):
        shown = call(*path, "--help").stdout
        assert "..." not in shown.partition("Commands:")[2], path
        if isinstance(command, click.Group):
            continue
        example = " ".join(shown.partition("Example: ")[2].split())
        assert example.startswith(f"mbsd3d {' '.join(path)}"), path
        given = [word for word in shlex.split(example) if word.startswith("--")]
        assert set(given) <= {option for x in command.params for option in x.opts}, path
