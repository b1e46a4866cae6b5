"""The site has a page for every public name and shows every example."""

import inspect
import pkgutil
import re
from importlib import import_module
from types import ModuleType

import pytest
from _documents import ROOT

import aicon_baselines
import aicon_envs
import aicon_torch

API = ROOT / "docs" / "api"
PAGES = {page: page.read_text() for page in API.glob("*.md")}

# What draws pictures for these documents, and whose names a package above it exports as well.
NOT_PUBLIC = ("aicon_baselines.figures", "aicon_envs.nav2d.maps")


def public_packages() -> list[str]:
    """The packages that say what they export."""
    found = []
    for root in (aicon_torch, aicon_envs, aicon_baselines):
        for module in pkgutil.iter_modules(root.__path__, f"{root.__name__}."):
            found += [module.name] if module.ispkg else []
            if module.ispkg:
                folder = f"{root.__path__[0]}/{module.name.rpartition('.')[2]}"
                below = pkgutil.iter_modules([folder], f"{module.name}.")
                found += [package.name for package in below if package.ispkg]
    return [name for name in found if not name.startswith(NOT_PUBLIC) and exports(name)]


def exports(name: str) -> bool:
    """Whether a package has `__all__`, found in its source: importing it may need an extra."""
    folders = {"aicon_torch": ROOT, "aicon_envs": ROOT / "envs"}
    root = folders.get(name.partition(".")[0], ROOT / "baselines")
    return "__all__" in (root / name.replace(".", "/") / "__init__.py").read_text()


PACKAGES = public_packages()


def test_the_packages_are_found() -> None:
    assert {"aicon_torch.parts.descriptions", "aicon_envs.reach", "aicon_baselines.diagnosis"} <= {
        *PACKAGES
    }


@pytest.mark.parametrize("package", PACKAGES)
def test_every_public_name_has_a_page_and_a_description(package: str) -> None:
    try:
        module = import_module(package)
    except ImportError as error:
        pytest.skip(f"{error}")

    (page,) = [text for text in PAGES.values() if f".. automodule:: {package}\n" in text]
    assert re.search(rf"automodule:: {package}\n   :members:\n   :imported-members:", page)
    for name in module.__all__:
        assert is_described(module, name, page), name


def is_described(module: ModuleType, name: str, page: str) -> bool:
    """Whether the page of a package shows one of its names, with a description.

    Sphinx describes classes and functions wherever they come from, and a constant, whose
    description stands in the module that defines it, where it is named itself.
    """
    named = getattr(module, name)
    if inspect.isclass(named) or inspect.isfunction(named):
        return bool(named.__doc__)
    return bool(re.search(rf"autodata:: {module.__name__}\.[\w.]*\b{name}\n", page))


def test_every_name_of_the_library_is_listed_and_described() -> None:
    listed = (API / "index.md").read_text().split()
    described = (API / "basics.md").read_text()
    packages = {package.split(".")[1] for package in PACKAGES}
    for name in aicon_torch.__all__:
        assert name in listed

        package = getattr(aicon_torch, name).__module__.split(".")[1]
        if package not in packages:
            assert f".. automodule:: aicon_torch.{package}\n" in described


def test_every_part_is_on_the_page_of_parts() -> None:
    page = (ROOT / "docs" / "parts.md").read_text()
    for name in import_module("aicon_torch.parts").__all__:
        assert re.search(rf"\b{name}\b", page), name


def test_every_example_is_shown() -> None:
    page = (ROOT / "docs" / "examples.md").read_text()
    for example in (ROOT / "examples").glob("*.py"):
        assert f"{{literalinclude}} ../examples/{example.name}\n" in page
