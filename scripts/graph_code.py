"""The code that makes a graph in examples/worlds: a function, and those of the folder in it.

Where the graph is one of the library's models, the functions of that are found, too.
"""

import ast
from collections.abc import Collection
from functools import cache
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
WORLDS = ROOT / "examples" / "worlds"
MODELS = "aicon_torch.models."


class Function(NamedTuple):
    """A function or method: the module in which it stands, and its code."""

    module: str
    code: ast.FunctionDef


def functions_of(module: str, name: str, without: Collection[str] = ()) -> list[Function]:
    """A function of a module, and all functions and methods of the folder that it leads to.

    Args:
        module: The module.
        name: The function.
        without: Names of functions that are left out, with what they alone lead to.
    """
    found: dict[tuple[str, int], Function] = {}
    new = _named(module, name)
    while new:
        function = new.pop()
        place = (function.module, function.code.lineno)
        if place not in found:
            found[place] = function
            for used in _names_in(function.code) - set(without):
                new += _named(function.module, used)
    return list(found.values())


def lines_of(functions: list[Function]) -> int:
    """How many lines functions have, without docstrings, comments and blank lines."""
    lines = set()
    for module, code in functions:
        text = _text(module).splitlines()
        for number in range(code.lineno, _end(code) + 1):
            line = text[number - 1].strip()
            if line and not line.startswith("#"):
                lines.add((module, number))

        for inner in ast.walk(code):
            if isinstance(inner, ast.FunctionDef) and ast.get_docstring(inner):
                docstring = inner.body[0]
                numbers = range(docstring.lineno, _end(docstring) + 1)
                lines -= {(module, number) for number in numbers}
    return len(lines)


def options_of(functions: list[Function]) -> set[str]:
    """The options that functions read: attributes of what they call `options`."""
    read = set()
    for _, code in functions:
        for node in ast.walk(code):
            match node:
                case ast.Attribute(value=ast.Name(id="options"), attr=name):
                    read.add(name)
    return read


def _named(module: str, name: str) -> list[Function]:
    """The functions and methods of this name, of a module or of one from which it has the name."""
    functions = []
    for node in _tree(module).body:
        if isinstance(node, ast.ImportFrom) and node.module and _path(node.module).is_file():
            for imported in node.names:
                if imported.name == name:
                    functions += _named(node.module, name)
        inner = node.body if isinstance(node, ast.ClassDef) else [node]
        for code in inner:
            if isinstance(code, ast.FunctionDef) and code.name == name:
                functions.append(Function(module, code))
    return functions


def _names_in(code: ast.FunctionDef) -> set[str]:
    names = set()
    for node in ast.walk(code):
        if isinstance(node, ast.Name):
            names.add(node.id)
        elif isinstance(node, ast.Attribute):
            names.add(node.attr)
    return names


@cache
def _tree(module: str) -> ast.Module:
    return ast.parse(_text(module))


@cache
def _text(module: str) -> str:
    return _path(module).read_text()


def is_model(module: str) -> bool:
    """Whether a module is one of the library's models, by its name."""
    return module.startswith(MODELS)


def _path(module: str) -> Path:
    if not module.startswith(MODELS):
        return WORLDS / f"{module}.py"
    path = ROOT.joinpath(*module.split("."))
    return path / "__init__.py" if path.is_dir() else path.with_suffix(".py")


def _end(code: ast.stmt) -> int:
    assert code.end_lineno is not None  # where it was parsed from text, it is there
    return code.end_lineno
