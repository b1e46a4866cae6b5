"""Sphinx's settings: the site of these pages, built by `make docs`."""

import sys
from pathlib import Path

from sphinx.application import Sphinx

import aicon_torch

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "scripts"))
from notebooks import NOTEBOOKS, save_notebook  # noqa: E402  # a script, not a package

project = "aicon-torch"
author = "the aicon-torch authors"
version = release = aicon_torch.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
    "sphinxcontrib.mermaid",
]
myst_enable_extensions = ["dollarmath"]
myst_fence_as_directive = ["mermaid"]
myst_heading_anchors = 4
suppress_warnings = ["myst.header"]  # a page that is included begins with its own heading

# README.md is what a reader of the repository sees of this folder; the site has index.md.
exclude_patterns = ["_build", "README.md"]

# Docstrings are Google's style; a word in single backquotes is code.
default_role = "code"
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
autodoc_preserve_defaults = True
napoleon_use_ivar = True

html_theme = "furo"
html_title = "aicon-torch"

# What pages link to outside this folder, and the page of the site that shows it.
PAGES = {
    "../SECURITY.md": "security.md",
    "../examples": "examples.md",
    "../aicon_torch": "api/index.md",
    "../aicon_torch/codegen": "api/codegen.md",
    "../baselines/checkpoints/diffusion_pusht_keypoints/README.md": "student.md",
    "../baselines/checkpoints/ppo_nav2d/README.md": "ppo_nav2d.md",
    "../baselines/checkpoints/ppo_pusht/README.md": "ppo_pusht.md",
}


def link_to_pages(app: Sphinx, page: str, source: list[str]) -> None:
    """Let a page's links to files of the repository lead to the pages that show them."""
    up = "../" * page.count("/")
    for target, shown in PAGES.items():
        source[0] = source[0].replace(f"]({up}{target})", f"]({up}{shown})")


def make_notebooks(app: Sphinx) -> None:
    """Make the notebooks of tutorials, for those who would rather run them."""
    for name in NOTEBOOKS:
        save_notebook(HERE / "tutorials" / f"{name}.md", HERE / "_build" / "_notebooks")


def link_to_notebook(app: Sphinx, page: str, source: list[str]) -> None:
    """Let a tutorial that is a notebook as well say so, below its title."""
    folder, _, name = page.rpartition("/")
    if folder == "tutorials" and name in NOTEBOOKS:
        link = f"{{download}}`a notebook <../_build/_notebooks/{name}.ipynb>`"
        source[0] = source[0].replace("\n\n", f"\n\n*This page is also {link}.*\n\n", 1)


def escape_bars(
    app: Sphinx, what: str, name: str, documented: object, options: object, lines: list[str]
) -> None:
    """Let ‖x‖ and |x| in a docstring stand for themselves: to Sphinx, bars mark a substitution."""
    for number, line in enumerate(lines):
        parts = line.split("``")
        parts[::2] = [words.replace("|", r"\|") for words in parts[::2]]
        lines[number] = "``".join(parts)


def setup(app: Sphinx) -> None:
    """Connect what is done to every page, and to every docstring."""
    app.connect("builder-inited", make_notebooks)
    app.connect("source-read", link_to_pages)
    app.connect("source-read", link_to_notebook)
    app.connect("autodoc-process-docstring", escape_bars)
