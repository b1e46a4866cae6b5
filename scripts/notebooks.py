"""Make notebooks of the tutorials, and draw the tutorials' pictures anew.

Example: python scripts/notebooks.py --out runs/notebooks --pictures docs/images

A tutorial is a page of the documentation, docs/tutorials/NAME.md, whose blocks of Python follow on
each other: jupytext reads it as a notebook. With --pictures it is run, and its last picture becomes
FOLDER/tutorial_NAME.png.
"""

import argparse
import base64
import re
from pathlib import Path
from typing import Any

from aicon_baselines.cli.command_line import Command, run_command

ROOT = Path(__file__).parents[1]
PAGES = tuple(sorted((ROOT / "docs" / "tutorials").glob("*.md")))

NOTEBOOKS = ("own_graph", "new_goal", "stuck")
"""The tutorials that the site offers as notebooks: they need no robot and no simulator."""

_PICTURE = re.compile(r"^!\[.*\]\(\.\./images/.*\)\n", re.MULTILINE)
_PRINTED = re.compile(r"^```text\n.*?^```\n", re.MULTILINE | re.DOTALL)


def to_notebook(page: Path) -> Any:
    """The notebook of a tutorial: without the pictures and the output that running it brings."""
    import jupytext

    text = page.read_text()
    for pattern in (_PICTURE, _PRINTED):
        text = pattern.sub("", text)
    text = text.replace("```bash\n", "```console\n")  # commands are shown, and not run
    notebook: Any = jupytext.reads(text, fmt="md")
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    notebook.metadata["kernelspec"] = kernel
    return notebook


def save_notebook(page: Path, folder: Path) -> Path:
    """Save the notebook of a tutorial in a folder, and return where."""
    import jupytext

    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{page.stem}.ipynb"
    jupytext.write(to_notebook(page), path)
    return path


def run_notebook(notebook: Any, folder: Path) -> list[str]:
    """Run a notebook, and return what it printed.

    Args:
        notebook: It gets the outputs of its cells.
        folder: Where it runs.

    Raises:
        nbclient.exceptions.CellExecutionError: If a cell fails.
    """
    from nbclient import NotebookClient

    NotebookClient(notebook, timeout=None, resources={"metadata": {"path": str(folder)}}).execute()
    return [output.text for output in _outputs(notebook) if output.output_type == "stream"]


def pictures_of(notebook: Any) -> list[bytes]:
    """The pictures that a notebook showed when it ran, as png."""
    data = [output.get("data", {}) for output in _outputs(notebook)]
    return [base64.b64decode(shown["image/png"]) for shown in data if "image/png" in shown]


def _outputs(notebook: Any) -> list[Any]:
    return [output for cell in notebook.cells for output in cell.get("outputs", ())]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare where things go."""
    parser.add_argument("--out", type=Path, metavar="FOLDER", help="save notebooks there")
    parser.add_argument("--pictures", type=Path, metavar="FOLDER", help="save pictures there")


def run(arguments: argparse.Namespace) -> None:
    """Save what is asked for."""
    for page in PAGES:
        if arguments.out:
            print(save_notebook(page, arguments.out))
        if arguments.pictures:
            notebook = to_notebook(page)
            run_notebook(notebook, ROOT)
            for picture in pictures_of(notebook)[-1:]:
                arguments.pictures.mkdir(parents=True, exist_ok=True)
                path = arguments.pictures / f"tutorial_{page.stem}.png"
                path.write_bytes(picture)
                print(path)


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
