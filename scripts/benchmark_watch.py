"""What watching costs: the rate that a control loop keeps, and its processor time, with the view.

Example: python scripts/benchmark_watch.py --tasks nav2d pusht arm_push reach

Each policy is compiled. First it runs alone, then with the view at its own rate; a page that is
open meanwhile (its address is printed) is served as well, and counts.
"""

import argparse
import time
from threading import Timer

import torch

from aicon_baselines.cli.command_line import Command, run_command
from aicon_baselines.view import LiveEpisode, LiveView, open_episode, serve

CONDITIONS = {"arm_push": "true_pose"}
"""Where the usual condition renders images, which would be all that is measured."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the tasks and the time."""
    parser.add_argument("--tasks", nargs="+", default=["nav2d", "pusht"], metavar="TASK")
    parser.add_argument("--seconds", type=float, default=20.0, help="with the view (default: 20)")
    parser.add_argument("--seed", type=int, default=1004)


def run(arguments: argparse.Namespace) -> None:
    """Measure task by task."""
    torch.set_num_threads(1)
    for task in arguments.tasks:
        episode = open_episode(task, condition=CONDITIONS.get(task), seed=arguments.seed)
        episode.compile()
        while not episode.compiled:
            time.sleep(0.1)

        alone = processor_time_alone(episode, arguments.seed)
        rate, watched = with_view(episode, arguments.seconds, arguments.seed)
        hertz = 1.0 / episode.time_step
        print(
            f"{task}: {rate:.1%} of {hertz:.0f} Hz; processor time of a step {1e3 * alone:.2f} ms "
            f"alone, {1e3 * watched:.2f} ms with the view ({watched / alone:.1f} times)",
            flush=True,
        )


def processor_time_alone(episode: LiveEpisode, seed: int, steps: int = 200) -> float:
    """Processor time of a step of environment and policy, s."""
    episode.start(seed)
    start = time.process_time()
    for _ in range(steps):
        step(episode, seed)
    return (time.process_time() - start) / steps


def with_view(episode: LiveEpisode, seconds: float, seed: int) -> tuple[float, float]:
    """The share of the control rate that is kept with the view, and a step's processor time, s."""
    episode.start(seed)
    view = LiveView(episode, serve("127.0.0.1", 0), compiles=False, loops=True)
    print(f"http://localhost:{view.port}", flush=True)

    timer = Timer(seconds, view.stop)
    timer.start()
    begun, worked = time.monotonic(), time.process_time()
    view.run()
    passed, used = time.monotonic() - begun, time.process_time() - worked
    view.close()
    return view.taken * episode.time_step / passed, used / view.taken


def step(episode: LiveEpisode, seed: int) -> None:
    """Go on; after the end, from the start."""
    if episode.ended:
        episode.start(seed)
    episode.step()


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
