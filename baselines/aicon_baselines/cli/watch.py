"""Watch a policy in the browser while it acts: the world, what it knows and what it decides.

Example: aicon watch pusht --policy steepest --seed 3

The page has a button to pause, others to step and to start another seed; goals can be weighted, the
rule for gradients in conflict changed, and targets and obstacles moved while the policy acts. Over
ssh: ssh -L 8080:localhost:8080 HOST, and open the page on your own machine. With --record there is
no page: the episode becomes one HTML file that plays in any browser, without a server.
"""

import argparse
import logging
import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from aicon_baselines.cli.command_line import Command, add_option, add_policy_option
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.files import replacing, writing
from aicon_baselines.tasks.registry import check_name, choices

if TYPE_CHECKING:
    from aicon_baselines.view import LiveEpisode

_LONGEST = 60.0  # s that are recorded
_EVERYWHERE = ("0.0.0.0", "127.0.0.1", "::")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the episode, the policy and the page."""
    parser.add_argument("task", metavar="TASK", help=choices())
    add_policy_option(parser)
    parser.add_argument("--condition", metavar="NAME", help="variant of the task")
    add_option(parser, "--seed", 0, "seed of the episode")

    add_option(parser, "--port", 8080, "port of the page")
    parser.add_argument(
        "--host", default="127.0.0.1", help="address to listen at (default: this machine only)"
    )
    parser.add_argument(
        "--allow-host",
        action="append",
        default=[],
        metavar="NAME",
        help="a name by which other machines may call the page, such as robot.local",
    )
    parser.add_argument(
        "--share",
        action="store_true",
        help="make the page public through share.viser.studio: who knows the address, steers",
    )

    parser.add_argument("--paused", action="store_true", help="wait for the button to begin")
    parser.add_argument("--loop", action="store_true", help="go on with seed after seed")
    parser.add_argument(
        "--record", type=Path, metavar="FILE", help="save the episode as html instead"
    )


def run(arguments: argparse.Namespace) -> None:
    """Serve the page until the user stops it, or save the recording."""
    _check(arguments)
    _tell_progress()

    import torch

    from aicon_baselines.view import opening

    torch.set_num_threads(1)
    opening.check_watchable(arguments.task)
    open_episode = opening.prepare_episode(
        arguments.task, arguments.policy, arguments.condition, arguments.seed
    )
    if arguments.record is None:
        _serve(open_episode, arguments)
    else:
        _record(open_episode(), arguments.record)


def _serve(open_episode: "Callable[[], LiveEpisode]", arguments: argparse.Namespace) -> None:
    """Say where the page is, build what it shows, and show it until the user stops it."""
    from aicon_baselines.view import LiveView, serve

    server = serve(arguments.host, arguments.port, arguments.allow_host)
    usual = signal.signal(signal.SIGINT, _end_at_once)
    try:
        name = "localhost" if arguments.host in _EVERYWHERE else arguments.host
        print(f"watch it at http://{name}:{server.get_port()} (Ctrl-C ends it)", flush=True)
        if arguments.share:
            print(f"public for a day, to whoever knows the address: {server.share()}", flush=True)

        with server.waiting("The policy and its world are being built."):
            episode = open_episode()
        LiveView(episode, server, paused=arguments.paused, loops=arguments.loop).run()
    finally:
        server.stop()
        signal.signal(signal.SIGINT, usual)


def _end_at_once(*_: object) -> None:
    """End at Ctrl-C.

    An exception may be lost on its way, where torch calls Python while it compiles; and torch
    aborts where Python takes down a thread that is still compiling.
    """
    print("\nstopped", file=sys.stderr, flush=True)
    os._exit(130)


def _tell_progress() -> None:
    """Have the live view say on stderr what it does, and its server nothing of pages that close."""
    logging.basicConfig(format="%(message)s")
    logging.getLogger("aicon_baselines.view").setLevel(logging.INFO)
    logging.getLogger("websockets").setLevel(logging.ERROR)
    print("Loading the library.", file=sys.stderr, flush=True)


def _check(arguments: argparse.Namespace) -> None:
    """Refuse what cannot be watched or recorded, before anything is built."""
    check_name(arguments.task)
    if not 0 <= arguments.port <= 65_535:
        raise ComparisonError(f"--port must be between 0 and 65535, not {arguments.port}")
    if arguments.record is not None and arguments.record.suffix != ".html":
        raise ComparisonError(f"a recording ends in .html, not {arguments.record.suffix!r}")


def _record(episode: "LiveEpisode", path: Path) -> None:
    """Save the episode as a page."""
    from aicon_baselines.view import record_html

    page = record_html(episode, _LONGEST)
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as place:
        place.write_text(page, encoding="utf-8")

    ending = "success" if episode.succeeded else "no success"
    print(f"{ending} after {episode.time:g} s; saved: {path}")


COMMAND = Command(__doc__, add_arguments, run)
