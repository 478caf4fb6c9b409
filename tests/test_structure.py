"""The house keeps its shape: a stack of folders, imports that go down, files one can take in at a glance."""

import ast
import importlib
import re
from functools import cache
from pathlib import Path

import pytest

import bicycle
import mbsd3d
import validation
from mbsd3d import errors, extend

ROOT = Path(__file__).parent.parent
TOPS = ("mbsd3d", "bicycle", "engines", "validation")  # each may import those before it; engines know no bicycle
STACK = (
    "base", "compiler", "kernels", "solver", "mechanism", "dynamics", "integrators", "equations", "constraints",
    "results", "run", "linear", "files", "plotting", "view", "report", "api", "linkages", "sweeps", "demos", "cli",
    "extend",
)  # fmt: skip
PUBLIC_MODULES = ("errors", "inertia", "linkages", "measures", "rotations", "shapes", "signals")
TOPICS = ("checks", "commands", "demos", "dynamics", "fields", "figures", "live", "trees")  # of mbsd3d.extend
LATE = ("api", "cli")
FACADES = ("validation.crosscheck.result", "mbsd3d.__main__", "mbsd3d.base.style")  # of matplotlib, the last
SMALL, ARGUMENTS = 60, 8  # lines of a module that a single other one imports; arguments of a function


def name_of(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


SOURCES = {name_of(path): path for top in TOPS for path in (ROOT / top).rglob("*.py")}


@cache
def tree_of(path: Path) -> ast.Module:
    """Return the syntax tree of a file, parsed once."""
    return ast.parse(path.read_text(encoding="utf-8"))


def imports(name: str) -> list[tuple[str, bool]]:
    """(module of ours that is imported, whether inside a function); imports for type checkers count too."""
    path = SOURCES[name]
    tree = tree_of(path)
    package = name if path.name == "__init__.py" else name.rpartition(".")[0]
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
    inner, found = {id(node) for function in functions for node in ast.walk(function)}, []
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            parts = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
            base = ".".join([*parts, *([node.module] if node.module else [])])
            for alias in node.names:
                whole = f"{base}.{alias.name}"
                target = whole if whole in SOURCES else base
                if target.split(".")[0] in TOPS and target != name:
                    found.append((target, id(node) in inner))
        elif isinstance(node, ast.Import):
            found += [(alias.name, id(node) in inner) for alias in node.names if alias.name in SOURCES]
    return found


@cache
def graph() -> dict[str, list[tuple[str, bool]]]:
    """Of every module, once it is asked for: the other workers of a run need not."""
    return {name: imports(name) for name in SOURCES}


def folder(module: str) -> str | None:
    """The folder of the stack a module of mbsd3d belongs to; None for the public names on top of all."""
    parts = module.split(".")
    return parts[1] if len(parts) > 1 and parts[1] in STACK else None


def test_every_folder_stands_in_the_stack():
    folders = {path.parent.name for path in (ROOT / "mbsd3d").glob("*/__init__.py")}
    assert folders == set(STACK)


def test_imports_go_down():
    wrong = []
    for name, targets in graph().items():
        if not name.startswith("mbsd3d.") or (here := folder(name)) is None:
            continue
        for target, _ in targets:
            there = folder(target)
            on_top = there is None and target not in ("mbsd3d", "mbsd3d.base") and target.startswith("mbsd3d")
            users = here in ("demos", "sweeps", "cli", "extend")  # they stand above all public names
            if (there and STACK.index(there) > STACK.index(here)) or (on_top and not users):
                wrong.append(f"{name} -> {target}")
    assert not wrong


def test_nothing_below_knows_the_packages_beside():
    wrong = [f"{name} -> {target}" for name, targets in graph().items() for target, _ in targets
             if (name.startswith("mbsd3d") and not target.startswith("mbsd3d"))
             or (name.startswith("bicycle") and target.startswith(("engines", "validation")))
             or (name.startswith("engines") and target.startswith(("bicycle", "validation")))]  # fmt: skip
    assert not wrong


def starts_late(name: str) -> bool:
    """Facades and commands import what is heavy when it is called."""
    parts = name.split(".")
    commands = {"commands", "command", "cli"} & set(parts)
    return folder(name) in LATE or bool(commands) or name in FACADES


def test_imports_stand_at_the_top():
    late = [
        f"{name} -> {target}"
        for name, targets in graph().items()
        for target, inside in targets
        if inside and not starts_late(name)
    ]
    assert not late


def above(module: str) -> list[str]:
    """A module and the packages it is in, as far as they are ours."""
    parts = module.split(".")
    return [whole for k in range(len(parts)) if (whole := ".".join(parts[: k + 1])) in SOURCES]


def test_no_circles():
    """A module is loaded after the packages it is in, so importing it imports these too."""
    edges = {
        name: {whole for target, _ in targets for whole in above(target) if not f"{name}.".startswith(f"{whole}.")}
        for name, targets in graph().items()
    }

    def below(start: str) -> set[str]:
        seen, todo = set(), [start]
        while todo:
            for target in edges[todo.pop()] - seen:
                seen.add(target)
                todo.append(target)
        return seen

    assert [name for name in edges if name in below(name)] == []


@pytest.mark.parametrize("package", ["bicycle", "engines", "validation"])
def test_packages_beside_use_public_names_only(package):
    allowed = {"mbsd3d", "mbsd3d.extend", *(f"mbsd3d.{module}" for module in PUBLIC_MODULES)}
    allowed |= {f"mbsd3d.extend.{topic}" for topic in TOPICS}
    wrong = [f"{name} -> {target}" for name, targets in graph().items() for target, _ in targets
             if name.startswith(package) and target.startswith("mbsd3d") and target not in allowed]  # fmt: skip
    assert not wrong


def test_theory_shares_nothing():
    for package in ("validation.theory", "engines.closed_forms"):
        assert not [name for name, targets in graph().items() if name.startswith(package)
                    for target, _ in targets if not target.startswith(package)]  # fmt: skip


def small_modules() -> set[str]:
    """Return the modules of few lines that one module imports: candidates to be part of that one."""
    users = {name: {user for user, targets in graph().items() if name in {t for t, _ in targets}} for name in SOURCES}
    return {
        name for name, path in SOURCES.items()
        if path.name not in ("__init__.py", "__main__.py") and len(users[name]) == 1
        and path.read_text(encoding="utf-8").count("\n") < SMALL
    }  # fmt: skip


def long_argument_lists() -> set[str]:
    """Return the functions with many arguments, but for kernels, whose arguments are arrays of one call."""
    found = set()
    for name, path in SOURCES.items():
        for node in ast.walk(tree_of(path)):
            if isinstance(node, ast.FunctionDef) and not any("kernel" in ast.dump(x) for x in node.decorator_list):
                arguments = node.args.posonlyargs + node.args.args + node.args.kwonlyargs
                if len(arguments) - (bool(arguments) and arguments[0].arg in ("self", "cls")) > ARGUMENTS:
                    found.add(f"{name}.{node.name}")
    return found


def known(what: str) -> set[str]:
    """Return the names under a heading of the list of what is to become less."""
    text = (ROOT / "tests" / "structure_debts.txt").read_text(encoding="utf-8")
    return set(text.split(f"# {what}\n")[1].split("\n\n")[0].split())


def test_small_modules_do_not_become_more():
    assert small_modules() <= known("small modules that one module imports")


def test_long_argument_lists_do_not_become_more():
    assert long_argument_lists() <= known("functions with more than 8 arguments")


LISTS = {"mbsd3d": ROOT / "mbsd3d" / "__init__.pyi"} | {
    f"mbsd3d.{module}": path for module in PUBLIC_MODULES if (path := ROOT / "mbsd3d" / f"{module}.py").exists()
}


def listed(path: Path) -> dict[str, str]:
    """Public name -> module that its list imports it from."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    found = [(node.module, alias) for node in tree.body if isinstance(node, ast.ImportFrom) for alias in node.names]
    assert all(alias.name == alias.asname for _, alias in found)  # what editors and type checkers take for public
    return {alias.name: f"mbsd3d.{module}" if module else "mbsd3d" for module, alias in found}


def test_public_names_are_listed_where_editors_look():
    assert set(mbsd3d.__all__) == set(listed(LISTS["mbsd3d"]))
    assert set(mbsd3d.__all__) >= {"Body", "System", "simulate", "linearize", "sweep", "load", *PUBLIC_MODULES}
    for package in (mbsd3d, extend, bicycle, validation):
        assert all(getattr(package, name) is not None for name in package.__all__)
        with pytest.raises(AttributeError, match=rf"module '{package.__name__}' has no attribute 'nothing'"):
            _ = package.nothing
    assert all((ROOT / package / "py.typed").exists() for package in TOPS)


@pytest.mark.parametrize("public", LISTS)
def test_a_public_name_is_listed_once(public):
    """It comes from the file that defines it: no package on the way lists it again."""
    for name, module in listed(LISTS[public]).items():
        value = getattr(importlib.import_module(module), name)
        assert getattr(value, "__module__", module) == module or module == "mbsd3d", name
        package = SOURCES[module].name == "__init__.py" and module != "mbsd3d"
        assert not package, name


@pytest.mark.parametrize(
    "module",
    [mbsd3d, extend, bicycle, validation, *(getattr(mbsd3d, name) for name in PUBLIC_MODULES)],
    ids=lambda module: module.__name__,
)
def test_completion_offers_public_names_alone(module):
    importlib.import_module("mbsd3d.linkages.bricard")  # modules that others have imported do not show
    own = set(module.__all__) if hasattr(module, "__all__") else set(listed(LISTS[module.__name__]))
    assert {name for name in dir(module) if not name.startswith("__")} == own - {"__version__"}


OWN_ERRORS = (
    "mbsd3d.integrators",
    "validation.theory",
    "engines.closed_forms",
)  # compiled with the kernels; shares nothing with mbsd3d


def test_what_is_refused_is_refused_by_one_base_class():
    """``except MbsError`` catches all: no error of Python's own is raised for what a user gave."""
    bare = [
        f"{name}: line {node.lineno}"
        for name, path in SOURCES.items()
        if not name.startswith(OWN_ERRORS)
        for node in ast.walk(tree_of(path))
        if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call) and isinstance(node.exc.func, ast.Name)
        if node.exc.func.id in ("ValueError", "TypeError", "KeyError", "IndexError", "RuntimeError", "Exception")
    ]
    assert not bare
    public = [value for value in vars(errors).values() if isinstance(value, type)]
    assert len(public) > 5 and all(issubclass(kind, errors.MbsError) for kind in public)
    assert issubclass(errors.MbsError, ValueError) and issubclass(errors.ArgumentError, TypeError)


def test_systems_and_solutions_have_types():
    """A parameter named system, solution or compiled says what it is, unless its kind is being checked."""
    loose = [
        f"{name}.{node.name}"
        for name, path in SOURCES.items()
        if name.startswith("mbsd3d.")
        for node in ast.walk(tree_of(path))
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("check_")
        for x in node.args.args
        if x.arg in ("system", "solution", "compiled")
        and isinstance(x.annotation, ast.Name)
        and x.annotation.id == "Any"
    ]
    assert not loose


TESTS = {path.relative_to(ROOT / "tests").as_posix(): path for path in (ROOT / "tests").rglob("*.py")}
PUBLIC = {
    *("mbsd3d", "mbsd3d.extend", "bicycle", "validation"),
    *(f"mbsd3d.{module}" for module in PUBLIC_MODULES),
    *(f"mbsd3d.extend.{topic}" for topic in TOPICS),
}


@cache
def imported(source: str) -> list[tuple[str, str]]:
    """(module, name) of all imports of a test, at the top and inside functions; the name of a module is empty."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom):
            for alias in node.names:
                whole = f"{node.module}.{alias.name}"
                found.append((whole, "") if whole in SOURCES else (f"{'.' * node.level}{node.module}", alias.name))
        elif isinstance(node, ast.Import):
            found += [(alias.name, "") for alias in node.names]
    return found


def neighbours(source: str) -> set[str]:
    """Return the test files that a source imports; besides them `test_what_tests_share_stands_in_one_folder`."""
    names = [f"{module}.{name}".removesuffix(".") for module, name in imported(source)]
    return {name for name in names if re.search(r"(^|\.)(test_|conftest\b)", name) or name[0] == "."}


def test_no_test_file_imports_another():
    wrong = {name: found for name, path in TESTS.items() if (found := neighbours(path.read_text(encoding="utf-8")))}
    assert not wrong, "what tests share stands in tests/helpers"


def test_what_tests_share_stands_in_one_folder():
    loose = {
        name for name in TESTS if not name.startswith(("helpers/", "types/")) and not Path(name).match("test_*.py")
    }
    assert loose == {"conftest.py"}
    assert not [name for name in TESTS if name.startswith("helpers/") and Path(name).match("test_*.py")]


def test_ablation_imports_between_tests_are_seen():
    assert neighbours("from test_files import pendulum") == {"test_files.pendulum"}
    assert neighbours("def f():\n    from files import test_files") == {"files.test_files"}
    assert neighbours("import view.test_live\nfrom ..view import live") == {"view.test_live", "..view.live"}
    assert neighbours("import numpy\nfrom helpers.models import pendulum\nfrom mbsd3d.view import page") == set()


@cache
def documented() -> frozenset[str]:
    """Modules, and names in them, of the packages beside that the pages name."""
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    text = " ".join(page.read_text(encoding="utf-8") for page in pages)
    return frozenset(re.findall(r"\b(?:bicycle|engines|validation)(?:\.[a-z_0-9]+)+", text))


def internals(name: str, source: str) -> list[tuple[str, str]]:
    """(module, name) that a test imports and that is neither public nor documented nor what the test is named after.

    Named after: all words of the file's name are in the path of the module, as in test_nvh_mounts and
    engines.nvh.mounts.response.
    """
    own = set(Path(name).stem.split("_")) - {"test"}
    return [
        (module, what)
        for module, what in imported(source)
        if module.split(".")[0] in TOPS and not {module, f"{module}.{what}"} & (PUBLIC | documented())
        if not (own and own <= set(re.split(r"[._]", module)))
    ]


def of_tests(*, constants: bool) -> set[str]:
    """Return the tests that import internals; of constants file and name."""
    found = set()
    for name, path in TESTS.items():
        for _, what in internals(name, path.read_text(encoding="utf-8")):
            if not constants:
                found.add(name)
            elif what.isupper():
                found.add(f"{name}:{what}")
    return found


def test_tests_of_internals_do_not_become_more():
    """A test uses public names and the module that it is named after."""
    assert of_tests(constants=False) <= known("tests that import internals")


def test_constants_of_internals_do_not_become_more():
    """A test asserts what a constant does."""
    assert of_tests(constants=True) <= known("constants of internals in tests")


def test_ablation_internals_are_seen():
    source = "from mbsd3d.view.camera import sight, VIEW\nfrom mbsd3d.rotations import matrix\nimport mbsd3d.run.job"
    assert internals("view/test_camera.py", source) == [("mbsd3d.run.job", "")]
    assert [what for _, what in internals("view/test_view.py", source)] == [""]
    assert [what for _, what in internals("run/test_motion.py", source)] == ["sight", "VIEW", ""]
