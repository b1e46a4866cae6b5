"""Sphinx's settings: the site of these pages, built by `make docs`."""

import io
import sys
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.parsers.rst import Directive
from matplotlib import mathtext
from matplotlib.font_manager import FontProperties
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.ext import autosummary
from sphinx.util.nodes import make_refnode

import aicon_torch

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE / "figures"), str(HERE / "web"), str(HERE.parent / "scripts")]
from flowcharts import draw  # noqa: E402  # among the figures of these pages
from make_pages import make_pages  # noqa: E402
from notebooks import NOTEBOOKS, save_notebook  # noqa: E402

project = "aicon-torch"
author = "the aicon-torch developers"
project_copyright = f"2026, {author}"
version = release = aicon_torch.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "sphinx_copybutton",
]
myst_enable_extensions = ["dollarmath"]
myst_fence_as_directive = ["mermaid"]
myst_heading_anchors = 4
suppress_warnings = ["myst.header"]  # a page that is included begins with its own heading

# README.md is what a reader of the repository sees of this folder; the site has index.md.
exclude_patterns = ["_build", "README.md", "web"]

# Docstrings are Google's style; a word in single backquotes is code.
default_role = "code"
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
autodoc_preserve_defaults = True
napoleon_use_ivar = True

# A point that does not end the first sentence of a docstring.
autosummary.WELL_KNOWN_ABBREVIATIONS += ("Eq.", "Eqs.", "Sect.", "Fig.")

# Nothing on the site comes from elsewhere: formulas and flowcharts are drawn when it is built.
html_theme = "furo"
html_title = "aicon-torch"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_math_renderer = "pictures"

# What pages link to outside this folder, and the page of the site that shows it.
PAGES = {
    "../SECURITY.md": "security.md",
    "../examples": "examples.md",
    "../aicon_torch": "api/index.md",
    "../aicon_torch/export/codegen": "api/export.md",
    "../baselines/checkpoints/diffusion_pusht_keypoints/README.md": "student.md",
    "../baselines/checkpoints/ppo_nav2d/README.md": "ppo_nav2d.md",
    "../baselines/checkpoints/ppo_pusht/README.md": "ppo_pusht.md",
    "../baselines/lerobot_robot_aicon/README.md": "lerobot_arms.md",
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


def make_pages_to_play_with(app: Sphinx, exception: Exception | None) -> None:
    """Put the pages where policies run beside those of the site."""
    if exception is None and app.builder.format == "html":
        make_pages(Path(app.outdir) / "try")


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


class Flowchart(Directive):
    """A block of mermaid, as a picture."""

    has_content = True

    def run(self) -> list[nodes.Node]:
        """Draw it."""
        picture = draw("\n".join(self.content))
        return [nodes.raw("", f'<div class="flowchart">{picture}</div>', format="html")]


def picture_of_formula(formula: str, size: float) -> str:
    """A formula as SVG in the colour of the text, its baseline on that of the line."""
    file, font = io.BytesIO(), FontProperties(size=size, math_fontfamily="cm")
    depth = mathtext.math_to_image(f"${formula}$", file, prop=font, dpi=72, format="svg")
    svg = file.getvalue().decode()
    svg = svg[svg.index("<svg") :].replace("<svg", f'<svg style="vertical-align: -{depth}pt"', 1)
    return svg.replace("fill: #ffffff", "fill: none").replace("<g ", '<g fill="currentColor" ', 1)


def write_inline_formula(writer: Any, node: nodes.Element) -> None:
    """A formula in a line."""
    writer.body.append(picture_of_formula(node.astext(), size=12))
    raise nodes.SkipNode


def write_formula(writer: Any, node: nodes.Element) -> None:
    """A formula by itself."""
    picture = picture_of_formula(node.astext(), size=15)
    writer.body.append(f'<div class="formula">{picture}</div>')
    raise nodes.SkipNode


def link_to_definition(
    app: Sphinx, env: BuildEnvironment, node: pending_xref, text: nodes.Element
) -> nodes.Element | None:
    """Let a name of `aicon_torch` itself lead to where a package below it describes it."""
    package = f"{aicon_torch.__name__}."
    name = str(node.get("reftarget", "")).removeprefix(package)
    if name.partition(".")[0] not in aicon_torch.__all__:
        return None

    for full, described in env.domains.python_domain.objects.items():
        if full.startswith(package) and full.endswith(f".{name}") and not described.aliased:
            page, anchor = described.docname, described.node_id
            return make_refnode(app.builder, node["refdoc"], page, anchor, text, full)
    return None


def setup(app: Sphinx) -> None:
    """Connect what is done to every page, and to every docstring."""
    app.add_directive("mermaid", Flowchart)
    app.add_html_math_renderer(
        "pictures",
        inline_renderers=(write_inline_formula, None),
        block_renderers=(write_formula, None),
    )
    app.connect("missing-reference", link_to_definition)
    app.connect("builder-inited", make_notebooks)
    app.connect("source-read", link_to_pages)
    app.connect("source-read", link_to_notebook)
    app.connect("autodoc-process-docstring", escape_bars)
    app.connect("build-finished", make_pages_to_play_with)
