"""Run one episode of a task, and tell how it ended and what the policy decided in its last step.

Example: aicon run --task nav2d --policy steepest --seed 3 --video runs/steepest.mp4

An episode is that of `aicon compare` with the same seed, but for rounding: there it is one of a
batch.
"""

import argparse
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from gymnasium.vector import VectorEnv

from aicon_baselines.agents.registry import factory
from aicon_baselines.agents.variants import parse_variant
from aicon_baselines.cli.command_line import Command, add_option, add_policy_option
from aicon_baselines.cli.compiling import add_compile_option, compiled_as_asked
from aicon_baselines.evaluation.config import one_episode
from aicon_baselines.evaluation.episodes import Step
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.rollout import Outcome, rollout
from aicon_baselines.evaluation.task import Task
from aicon_baselines.extras import naming_extra
from aicon_baselines.files import replacing
from aicon_baselines.tasks import choices, load

_PICTURES_PER_SECOND = 20  # of a video, about; it runs as fast as the episode did


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the episode, the policy and what to save."""
    parser.add_argument("--task", required=True, metavar="TASK", help=choices())
    add_policy_option(parser)
    parser.add_argument("--condition", metavar="NAME", help="variant of the task (default: first)")
    add_option(parser, "--seed", 0, "seed of the episode")
    parser.add_argument(
        "--horizon", type=int, metavar="STEPS", help="limit of the episode (default: the task's)"
    )
    add_compile_option(parser)
    parser.add_argument("--video", type=Path, metavar="FILE", help="save a film, as mp4 or gif")


def run(arguments: argparse.Namespace) -> None:
    """Run the episode; print its outcome and the policy's last decision."""
    # 1. The episode ...
    task, condition = one_episode(
        load(arguments.task), arguments.condition, arguments.seed, arguments.horizon
    )

    # 2. ... the policy ...
    import torch

    torch.set_num_threads(1)
    name, options = parse_variant(arguments.policy)
    builds = {name: factory(task.name, name, **options)}
    build = compiled_as_asked(builds, arguments.compile)[name]
    policy: Any = build(condition)

    # 3. ... and the loop, with a picture now and then.
    memory: Any = None
    steps = 0
    episodes = [task.episode(arguments.seed)]
    every = max(1, round(1.0 / (_PICTURES_PER_SECOND * task.time_step)))
    with _film_writer(arguments.video, every * task.time_step) as film:

        def on_step(env: VectorEnv[Any, Any, Any], step: Step) -> None:
            nonlocal memory, steps
            is_last = step.ended.all() or steps + 1 == task.horizon
            if film is not None and (steps % every == 0 or is_last):
                film.append_data((env.render() or ())[0])
            memory, steps = step.memory, steps + 1

        seeing: dict[str, Any] = {} if film is None else {"render_mode": "rgb_array"}
        seeds = [arguments.seed]
        outcome = rollout(policy, task, condition, episodes, seeds, on_step=on_step, **seeing)

    # 4. What came of it.
    print(describe_outcome(task, outcome))
    if hasattr(policy, "explain"):  # a planner has nothing to tell
        print(f"\nits last step:\n{policy.explain(memory, 0)}")
    if arguments.video:
        print(f"saved: {arguments.video}")


def describe_outcome(task: Task, outcome: Outcome) -> str:
    """Say in a line how the one episode of an outcome ended."""
    ending = "success" if outcome.success[0] else "no success"
    if outcome.collision[0]:
        ending += ", with a collision"

    unit = task.length_unit
    parts = [
        f"{ending} after {task.duration(int(outcome.steps[0]))}",
        f"path {outcome.path_length[0]:.4g} {unit}",
        f"{outcome.distance[0]:.3g} {unit} left",
    ]
    for measure in task.measures:
        value = measure.form.format(measure.scale * outcome.measures[measure.key][0])
        parts.append(f"{measure.key} {value}")
    return "; ".join(parts)


@contextmanager
def _film_writer(path: Path | None, interval: float) -> Iterator[Any]:
    """Give what writes pictures, one in so many seconds, into a film; None without a path."""
    if path is None:
        yield None
        return
    if path.suffix not in (".mp4", ".gif"):
        raise ComparisonError(f"a video ends in .mp4 or .gif, not {path.suffix!r}")

    with naming_extra():
        import imageio.v2 as imageio

    path.parent.mkdir(parents=True, exist_ok=True)
    options: dict[str, Any] = {"fps": 1.0 / interval}
    if path.suffix == ".gif":
        options = {"duration": 1000 * interval, "loop": 0}
    with replacing(path) as place, imageio.get_writer(place, **options) as writer:
        yield writer


COMMAND = Command(__doc__, add_arguments, run)
