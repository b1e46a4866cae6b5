"""Make the pages to play with: one HTML file each, its policies in it, nothing from elsewhere.

Example: python docs/web/make_pages.py docs/_build/try
"""

import argparse
import gzip
import json
import re
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from string import Template
from typing import Any, NamedTuple

from aicon_baselines import palette
from aicon_baselines.cli.command_line import Command, run_command

HERE = Path(__file__).parent
sys.path.append(str(HERE.parent / "figures"))  # the pictures of the concepts have a world to share
from building import arm_page, navigation, pushing, scripts, theory  # noqa: E402


class Page(NamedTuple):
    """A page.

    Attributes:
        script: The module that it runs.
        data: Makes what it holds.
    """

    script: str
    data: Callable[[], dict[str, Any]]


PAGES: Mapping[str, Page] = {
    "navigation": Page("tasks/navigation.mjs", navigation.data),
    "pusht": Page("tasks/pusht.mjs", pushing.data),
    "arm": Page("tasks/arm.mjs", arm_page.data),
    "theory": Page("theory/theory.mjs", theory.data),
}
"""The pages by name."""


def make_pages(folder: Path, names: tuple[str, ...] = tuple(PAGES)) -> None:
    """Write pages to a folder.

    Raises:
        FileNotFoundError: If there is no Node.js.
        RuntimeError: If npm or esbuild fails; what they print is told.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for name in names:
        (folder / f"{name}.html").write_text(page(name), encoding="utf-8")


def page(name: str) -> str:
    """A page as HTML."""
    title, body = body_of(name)
    data = {"palette": colors(), **PAGES[name].data()}
    frame = Template((HERE / "pages" / "frame.html").read_text(encoding="utf-8"))
    whole = frame.substitute(
        title=title,
        style=(HERE / "pages" / "style.css").read_text(encoding="utf-8"),
        body=body,
        data=json.dumps(data, separators=(",", ":")).replace("</", r"<\/"),
        script=scripts.bundle(PAGES[name].script),
    )
    return whole.replace(f'<a href="{name}.html">', f'<a href="{name}.html" aria-current="page">')


def body_of(name: str) -> tuple[str, str]:
    """The title and the body of a page, from its words."""
    words = (HERE / "pages" / f"{name}.html").read_text(encoding="utf-8")
    found = re.search(r"<h1>(.*?)</h1>", words)
    assert found, f"{name}.html has no <h1>"
    if "<main>" in words:
        return found[1], words

    # The words of a task are put into the frame that all tasks have.
    parts = re.split(r"<!-- (\w+) -->", words)
    slots = dict(zip(parts[1::2], parts[2::2], strict=True))
    task = Template((HERE / "pages" / "task.html").read_text(encoding="utf-8"))
    return found[1], task.substitute(title=found[1], **slots)


def colors() -> dict[str, str]:
    """The palette of the figures by name."""
    named = vars(palette).items()
    return {name: color for name, color in named if name.isupper() and isinstance(color, str)}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare where pages are written, and which."""
    parser.add_argument("folder", type=Path, metavar="FOLDER", help="of the pages")
    names = ", ".join(PAGES)
    parser.add_argument("--only", nargs="+", choices=tuple(PAGES), metavar="PAGE", help=names)


def run(arguments: argparse.Namespace) -> None:
    """Make pages, and say how large they are."""
    names = tuple(arguments.only or PAGES)
    make_pages(arguments.folder, names)
    for name in names:
        packed = gzip.compress((arguments.folder / f"{name}.html").read_bytes())
        print(f"{name}: {len(packed) / 1000:.0f} kB by gzip")


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
