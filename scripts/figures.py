"""Draw the paper's figures from real rollouts.

Example: python scripts/figures.py nav2d --out runs/figures

nav2d saves nav2d_rollout.png (six moments of the evolving potential), nav2d_rollout.json (the figure's numbers) and
nav2d_rollout.mp4 or .gif.
"""

import argparse
import os
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")  # read when torch is loaded

from aicon_baselines import ComparisonError
from aicon_baselines.navigation_figure import VIDEOS, make_figure


def main() -> None:
    """Parse the arguments, draw and save the figure, and say what it shows."""
    parser = _parser()
    arguments = parser.parse_args()
    try:
        numbers = make_figure(arguments.map, arguments.seed, arguments.out, arguments.video)
    except ComparisonError as error:
        parser.error(str(error))
    except KeyboardInterrupt:
        parser.exit(130, "\nstopped\n")
    print(f"{numbers['ending']} after {numbers['duration_s']} s and {numbers['path_length_m']} m")
    for panel in numbers["panels"]:
        print(f"  ({panel['panel']}) {panel['time_s']:6.2f} s  {panel['title']}")
    saved = [f"nav2d_rollout.{kind}" for kind in ("png", "json", arguments.video) if kind != "none"]
    print(f"saved in {arguments.out}: {', '.join(saved)}")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    figures = parser.add_subparsers(dest="figure", required=True, metavar="FIGURE")
    nav2d = figures.add_parser(
        "nav2d",
        help="2D navigation: the evolving potential",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    nav2d.add_argument("--map", default="u_trap_2", metavar="NAME", help="class of the map (default: u_trap_2)")
    nav2d.add_argument("--seed", type=int, default=1006, help="seed of the map and of the noise (default: 1006)")
    nav2d.add_argument("--out", type=Path, default=Path("runs/figures"), help="folder (default: runs/figures)")
    nav2d.add_argument("--video", choices=VIDEOS, default="mp4", help="kind of video (default: mp4)")
    return parser


if __name__ == "__main__":
    main()
