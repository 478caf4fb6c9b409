"""The digest of the compiled sources: no kernel uses anything of ours from a file that it does not cover."""

import ast
from pathlib import Path

import pytest

import mbsd3d
from mbsd3d.compiler import cache_folder
from mbsd3d.extend import compiled_sources

PACKAGE = Path(mbsd3d.__file__).parent
SOURCES = compiled_sources()


def decorated(tree):
    """The kernels of a module, those made inside functions too."""
    return [
        node
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef)
        and any(isinstance(x, ast.Name) and x.id.endswith("kernel") for x in node.decorator_list)
    ]


def imported(path, tree):
    """Name -> file of ours that it is imported from."""
    found = {}
    for node in tree.body:
        if isinstance(node, ast.ImportFrom) and node.level:
            base = path.parents[node.level - 1].joinpath(*(node.module or "").split("."))
            for alias in node.names:
                inside = (base / alias.name).with_suffix(".py")
                found[alias.asname or alias.name] = inside if inside.exists() else base.with_suffix(".py")
    return found


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_kernels_use_compiled_sources_only(path):
    tree = ast.parse(path.read_text(encoding="utf-8"))
    where = imported(path, tree)
    used = {x.id for kernel in decorated(tree) for x in ast.walk(kernel) if isinstance(x, ast.Name)}
    assert {name for name in used & set(where) if where[name] not in SOURCES} == set()
    assert path.parent.name == "integrators" or not any("integrators" in file.parts for file in where.values())


def test_every_file_with_a_kernel_is_covered():
    files = [x for x in PACKAGE.rglob("*.py") if decorated(ast.parse(x.read_text(encoding="utf-8")))]
    assert len(files) > 20 and set(files) <= set(SOURCES)


def test_another_numba_compiles_anew(monkeypatch):
    before = cache_folder._digest([b"source"])
    monkeypatch.setattr(cache_folder.numba, "__version__", "0.0")
    assert cache_folder._digest([b"source"]) != before


def test_every_compiled_function_is_a_decorated_one():
    """What `compiled_sources` looks for is the decorator: nothing is compiled by a call of one."""
    calls = [
        f"{path.relative_to(PACKAGE)}: {node.func.id}"
        for path in PACKAGE.rglob("*.py")
        if path.name != "decorators.py"
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
        if node.func.id in ("compiled", "kernel", "inner_kernel", "fused_kernel", "merged_kernel", "allocating_kernel")
    ]
    assert calls == []
