"""Draw the paper's figures from real rollouts.

Example: aicon figures nav2d --out runs/figures

nav2d saves nav2d_rollout.png (six moments of the evolving potential), nav2d_rollout.json (the
figure's numbers) and the film nav2d_rollout.mp4. pusht saves the same as pusht_rollout: six moments
of an episode, and the gradients that arrive at the pusher. pusht_pixels: the pictures that it sees,
and where a network and the filter have the object in them. arm_push saves the same as
arm_push_film: the arm from outside and from its hand, and its gradients. reach saves reach.png,
moments of three arms' episodes beside their errors and gaps, and reach.mp4, one of them with a ball
in its way. With --video webp a film is a small moving picture for a page.
"""

import argparse
from importlib import import_module
from pathlib import Path
from typing import Any

from aicon_baselines.cli.command_line import Command, add_option, at_least

_FIGURES = {
    "nav2d": "2D navigation: the evolving potential",
    "pusht": "pushing: the gradients that arrive at the pusher",
    "pusht_pixels": "pushing by pictures that are covered: what is seen and what is believed",
    "arm_push": "pushing with an arm: its views and its gradients",
    "reach": "reaching with three arms: moments, errors and gaps",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the figures, each with its own arguments."""
    figures = parser.add_subparsers(dest="figure", required=True, metavar="FIGURE")
    for name, title in _FIGURES.items():
        figure = figures.add_parser(name, help=title, description=title)
        add_option(figure, "--out", Path("runs/figures"), "folder of the files")
        figure.add_argument(
            "--seed", type=at_least(0), help="seed of the episode (default: one that shows it all)"
        )
        add_option(figure, "--video", "mp4", "mp4, webp or none")
        if name == "nav2d":
            figure.add_argument("--map", metavar="NAME", help="class of maps (default: a trap)")


def run(arguments: argparse.Namespace) -> None:
    """Draw and save the figure, and say what it shows."""
    # What is left out is for the figure to decide.
    options: dict[str, Any] = {}
    for argument, option in (("seed", "seed"), ("map", "map_name"), ("video", "video")):
        value = getattr(arguments, argument, None)
        if value is not None:
            options[option] = value

    # Imported by name: a figure needs its task's environment, which may come with an extra.
    module = import_module(f"aicon_baselines.figures.{arguments.figure}")
    print(module.make_figure(arguments.out, **options))


COMMAND = Command(__doc__, add_arguments, run)
