"""The house keeps its order: imports point one way, packages export and hold nothing else."""

import ast
import dataclasses
import functools
import sys
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from aicon_torch import Exploration, NullspaceProjection, TrapEscape, make_policy

ROOT = Path(__file__).parent.parent
PACKAGES = {
    "aicon_torch": ROOT / "aicon_torch",
    "aicon_envs": ROOT / "envs" / "aicon_envs",
    "aicon_baselines": ROOT / "baselines" / "aicon_baselines",
}

LAZY = {
    ("aicon_torch.policy", "aicon_torch.export.inductor"),
    ("aicon_torch.policy", "aicon_torch.export.exporting"),
    ("aicon_torch.export.native", "aicon_torch.export.exporting"),
    ("aicon_torch.export.inductor", "torch._inductor"),
}
"""Imports inside functions, which are permitted because they load a compiler or a translator."""


def files(package: str) -> list[Path]:
    return sorted(PACKAGES[package].rglob("*.py"))


def module_of(package: str, file: Path) -> str:
    """``aicon_torch.graph`` of aicon_torch/graph/__init__.py."""
    parts = file.relative_to(PACKAGES[package].parent).with_suffix("").parts
    return ".".join(parts).removesuffix(".__init__")


def imports(tree: ast.AST) -> Iterator[tuple[str, ast.stmt]]:
    """What is imported, with its statement, wherever it stands: in functions and branches, too.

    ``from a.b import c`` imports ``a.b.c``, a module or something that ``a.b`` holds.
    """
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield alias.name, node
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"line {node.lineno}: a relative import"
            for alias in node.names:
                yield f"{node.module}.{alias.name}", node


@functools.cache
def trees(package: str) -> dict[str, ast.Module]:
    """The syntax tree of each module."""
    return {module_of(package, file): ast.parse(file.read_text()) for file in files(package)}


# --- what imports what


@pytest.mark.parametrize(
    ("package", "others"),
    [
        ("aicon_torch", ("aicon_envs", "aicon_baselines", "gymnasium")),
        ("aicon_envs", ("aicon_torch", "aicon_baselines")),
    ],
)
def test_imports_point_one_way(package: str, others: tuple[str, ...]) -> None:
    for module, tree in trees(package).items():
        for imported, node in imports(tree):
            assert imported.split(".")[0] not in others, f"{module}, line {node.lineno}: {imported}"


def test_the_library_imports_torch_and_numpy_only() -> None:
    allowed = {"aicon_torch", "torch", "numpy"} | sys.stdlib_module_names

    for module, tree in trees("aicon_torch").items():
        for imported, node in imports(tree):
            assert imported.split(".")[0] in allowed, f"{module}, line {node.lineno}: {imported}"


def test_only_the_compiler_is_imported_lazily() -> None:
    found: set[tuple[str, str]] = set()

    for module, tree in trees("aicon_torch").items():
        for imported, node in imports(tree):
            if node not in tree.body:
                source = node.module if isinstance(node, ast.ImportFrom) else imported
                found.add((module, str(source)))

    assert found == LAZY


def dependencies() -> dict[str, set[str]]:
    """For each module of the library those that it imports, lazily or for its types included."""
    library = trees("aicon_torch")
    found: dict[str, set[str]] = {}

    for module, tree in library.items():
        found[module] = set()
        for imported, _ in imports(tree):
            package, _, _ = imported.rpartition(".")
            found[module] |= {imported} & library.keys() or {package} & library.keys()

    return found


def test_modules_do_not_import_each_other_in_a_circle() -> None:
    assert_no_circle(dependencies())


def test_packages_do_not_import_each_other_in_a_circle() -> None:
    """Estimation, graph, resolution, control, parts and models, each as one."""
    packages: dict[str, set[str]] = {}

    for module, imported in dependencies().items():
        package = module.split(".")[:2][-1]
        others = packages.setdefault(package, set())
        others |= {other.split(".")[:2][-1] for other in imported} - {package}

    assert_no_circle(packages)


def assert_no_circle(graph: dict[str, set[str]]) -> None:
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(" → ".join(reversed(error.args[1])))


# --- what a file holds


def is_export(statement: ast.stmt) -> bool:
    """Whether a statement is an import, a docstring, ``__all__`` or ``__version__``."""
    if isinstance(statement, ast.Import | ast.ImportFrom):
        return True
    if isinstance(statement, ast.Expr):
        return isinstance(statement.value, ast.Constant)
    if isinstance(statement, ast.Assign):
        return ast.unparse(statement.targets[0]) in ("__all__", "__version__")
    return False


@pytest.mark.parametrize("package", PACKAGES)
def test_a_package_exports_and_holds_nothing_else(package: str) -> None:
    for file in files(package):
        if file.name != "__init__.py":
            continue

        tree = ast.parse(file.read_text())
        assert ast.get_docstring(tree), file
        others = [ast.unparse(node).split("\n")[0] for node in tree.body if not is_export(node)]
        assert others == [], file


def test_a_test_file_is_about_one_topic() -> None:
    tests = sorted((ROOT / "tests").rglob("*.py"))
    long = [str(file) for file in tests if len(file.read_text().splitlines()) >= 250]
    assert long == []


# --- defaults


def test_defaults_are_what_we_ship_and_not_the_text() -> None:
    assert NullspaceProjection() != NullspaceProjection.as_in_paper()
    assert Exploration() != Exploration.as_in_paper()
    assert NullspaceProjection().exploration == Exploration()
    assert NullspaceProjection.as_in_paper().exploration == Exploration.as_in_paper()


def test_the_shipped_models_use_the_shipped_defaults() -> None:
    """But for what leaving a trap needs, which names their goals."""
    for name in ("nav2d", "pusht"):
        rule = make_policy(name).resolution
        assert isinstance(rule, NullspaceProjection) and rule.exploration is not None

        plain = dataclasses.replace(rule.exploration, escape=TrapEscape())
        assert dataclasses.replace(rule, exploration=plain) == NullspaceProjection()
