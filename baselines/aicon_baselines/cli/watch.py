"""Watch a policy in the browser while it acts: the world, what it knows and what it decides.

Example: aicon watch pusht --policy steepest --seed 3

The page has a button to pause, others to step and to start another seed; goals can be switched off
and on, the rule for gradients in conflict changed, and the target moved while the policy acts.
Over ssh: ssh -L 8080:localhost:8080 HOST, and open the page on your own machine.
"""

import argparse
import logging

import torch

from aicon_baselines.agents.variants import REFERENCE
from aicon_baselines.cli.command_line import Command
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.tasks.registry import check_name
from aicon_baselines.view import LiveView, open_episode
from aicon_baselines.view.scenes import check_watchable

_EVERYWHERE = ("0.0.0.0", "127.0.0.1", "::")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the episode, the policy and the page."""
    parser.add_argument("task", metavar="TASK", help="name of the task, such as pusht or nav2d")
    parser.add_argument(
        "--policy",
        default=REFERENCE,
        metavar="TEXT",
        help="policy, option=value,... or both, such as steepest,max_speed=0.3 (default: aicon)",
    )
    parser.add_argument("--condition", metavar="NAME", help="variant of the task (default: first)")
    parser.add_argument("--seed", type=int, default=0, help="seed of the episode (default: 0)")
    parser.add_argument("--port", type=int, default=8080, help="port of the page (default: 8080)")
    parser.add_argument(
        "--host", default="127.0.0.1", help="address to listen at (default: this machine only)"
    )
    parser.add_argument("--paused", action="store_true", help="wait for the button to begin")


def run(arguments: argparse.Namespace) -> None:
    """Serve the page until the user stops it."""
    torch.set_num_threads(1)
    _check(arguments)
    check_watchable(arguments.task)
    logging.getLogger("websockets").setLevel(logging.ERROR)  # a page that closes is no error

    episode = open_episode(
        arguments.task, arguments.policy, arguments.condition, seed=arguments.seed
    )
    view = LiveView(episode, arguments.port, arguments.host, paused=arguments.paused)
    try:
        name = "localhost" if arguments.host in _EVERYWHERE else arguments.host
        print(f"watch it at http://{name}:{view.port} (Ctrl-C ends it)", flush=True)
        view.run()
    finally:
        view.close()


def _check(arguments: argparse.Namespace) -> None:
    """Refuse what cannot be watched, before anything is built."""
    check_name(arguments.task)
    if not 0 <= arguments.port <= 65_535:
        raise ComparisonError(f"--port must be between 0 and 65535, not {arguments.port}")


COMMAND = Command(__doc__, add_arguments, run)
