"""The site has a page for every public name and shows every example."""

from importlib import import_module
from inspect import isclass, isfunction

import pytest
from _documents import ROOT

import aicon_torch

API = ROOT / "docs" / "api"
PACKAGES = ("codegen", "control", "estimation", "graph", "models", "parts", "resolution", "safety")


def test_every_package_has_a_page() -> None:
    folders = {path.parent.name for path in (ROOT / "aicon_torch").glob("*/__init__.py")}
    assert folders == set(PACKAGES)
    for package in PACKAGES:
        page = (API / f"{package}.md").read_text()
        assert f".. automodule:: aicon_torch.{package}\n" in page
        assert ":imported-members:" in page  # those of __all__


def test_every_name_of_the_library_is_listed_and_described() -> None:
    listed = (API / "index.md").read_text().split()
    described = (API / "basics.md").read_text()
    for name in aicon_torch.__all__:
        assert name in listed

        package = getattr(aicon_torch, name).__module__.split(".")[1]
        if package not in PACKAGES:
            assert f".. automodule:: aicon_torch.{package}\n" in described


@pytest.mark.parametrize("package", PACKAGES)
def test_what_a_page_describes_says_what_it_is(package: str) -> None:
    module = import_module(f"aicon_torch.{package}")
    for name in module.__all__:
        described = getattr(module, name)
        if isfunction(described) or isclass(described):
            assert described.__doc__, name


def test_every_example_is_shown() -> None:
    page = (ROOT / "docs" / "examples.md").read_text()
    for example in (ROOT / "examples").glob("*.py"):
        assert f"{{literalinclude}} ../examples/{example.name}\n" in page
