"""Draw the paper's figures from real rollouts.

Example: aicon figures nav2d --out runs/figures

nav2d saves nav2d_rollout.png (six moments of the evolving potential), nav2d_rollout.json (the
figure's numbers) and nav2d_rollout.mp4 or .gif. pusht saves the same as pusht_rollout: six moments
of an episode, and the gradients that arrive at the pusher. panda_push saves panda_push_film.mp4 or
.gif, an episode of the arm from outside and from its hand above the strengths of its gradients, and
panda_push_film.png, a picture from the middle of it.
"""

import argparse
from pathlib import Path
from typing import Any

from aicon_baselines.cli.command_line import Command
from aicon_baselines.figures.pictures import VIDEOS


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the figures, each with its own arguments."""
    figures = parser.add_subparsers(dest="figure", required=True, metavar="FIGURE")

    nav2d = figures.add_parser("nav2d", help="2D navigation: the evolving potential")
    nav2d.add_argument("--map", default="u_trap_2", metavar="NAME", help="default: u_trap_2")
    # The seed of pushT is the shortest episode of 1000 to 1059 that shows all six moments.
    pusht = figures.add_parser("pusht", help="pushing: the gradients that arrive at the pusher")
    arm = figures.add_parser("panda_push", help="pushing with an arm: its views and gradients")

    for figure, seed in ((nav2d, 1006), (pusht, 1050), (arm, 1000)):
        figure.add_argument(
            "--seed", type=int, default=seed, help=f"seed of the episode (default: {seed})"
        )
        figure.add_argument(
            "--out", type=Path, default=Path("runs/figures"), help="default: runs/figures"
        )
        figure.add_argument(
            "--video", choices=VIDEOS, default="mp4", help="kind of video (default: mp4)"
        )


def run(arguments: argparse.Namespace) -> None:
    """Draw and save the figure, and say what it shows."""
    # A figure needs its task's environment, which may come with an extra.
    seed, out, video = arguments.seed, arguments.out, arguments.video

    if arguments.figure == "nav2d":
        from aicon_baselines.figures import nav2d

        numbers = nav2d.make_figure(arguments.map, seed, out, video)
        _tell(numbers, f"{numbers['path_length_m']} m", arguments)

    elif arguments.figure == "pusht":
        from aicon_baselines.figures import pusht

        numbers = pusht.make_figure(seed, out, video)
        _tell(numbers, f"{numbers['path_length_px']} px", arguments)

    else:
        from aicon_baselines.figures import panda_push

        film = panda_push.make_film(seed, out, video)
        ending = "success" if film.success else "no success"
        print(f"{ending} after {film.times[-1]:.1f} s; saved in {out}")


def _tell(numbers: dict[str, Any], path_length: str, arguments: argparse.Namespace) -> None:
    """Print how the episode ended, its six moments and what was saved."""
    print(f"{numbers['ending']} after {numbers['duration_s']} s and {path_length}")
    for panel in numbers["panels"]:
        print(f"  ({panel['panel']}) {panel['time_s']:6.2f} s  {panel['title']}")

    kinds = ["png", "json"] if arguments.video == "none" else ["png", "json", arguments.video]
    files = ", ".join(f"{arguments.figure}_rollout.{kind}" for kind in kinds)
    print(f"saved in {arguments.out}: {files}")


COMMAND = Command(__doc__, add_arguments, run)
