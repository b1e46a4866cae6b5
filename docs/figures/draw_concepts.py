"""Draw the six pictures of docs/concepts.md, from what the policy of a small world computes.

Example: python docs/figures/draw_concepts.py --out docs/images
"""

import argparse
from collections.abc import Callable, Mapping
from pathlib import Path

from aicon_baselines.cli.command_line import Command, add_option, run_command
from concepts import conflict, exploration, foresight, meeting, path, projection

PICTURES: Mapping[str, Callable[[Path], None]] = {
    "path": path.draw,
    "meeting": meeting.draw,
    "projection": projection.draw,
    "conflict": conflict.draw,
    "exploration": exploration.draw,
    "foresight": foresight.draw,
}
"""What draws each picture."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the folder."""
    add_option(parser, "--out", Path("docs/images"), "folder of the pictures")


def run(arguments: argparse.Namespace) -> None:
    """Draw the pictures, each into a file of its own."""
    arguments.out.mkdir(parents=True, exist_ok=True)
    for name, draw in PICTURES.items():
        draw(arguments.out / f"concept_{name}.png")


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
