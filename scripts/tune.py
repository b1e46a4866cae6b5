"""Search over law and speed, the same for every policy of a task, on seeds that are not reported.

Example: python scripts/tune.py --policies aicon paper_literal steepest --jobs 2 --out runs/tune

The best of each policy is what its preset should hold. The same command goes on where a stopped run
was.
"""

import argparse
from itertools import product
from pathlib import Path
from typing import NamedTuple

from aicon_baselines.agents.registry import factory
from aicon_baselines.cli.command_line import RESUMABLE, Command, add_option, run_command
from aicon_baselines.cli.compiling import add_compile_option, compiled_as_asked
from aicon_baselines.evaluation.comparison import compare
from aicon_baselines.evaluation.config import configure
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.predictor import Factory
from aicon_baselines.evaluation.report import write_report
from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.tasks import load
from aicon_torch.control import ActionLaw, DirectDescent, Foresight
from aicon_torch.models.pusht import PIXEL

FIRST_SEED = 1000
"""Seeds below this are for reporting."""


class Search(NamedTuple):
    """What is searched unless asked otherwise, on which seeds; speeds in m/s."""

    steps: tuple[float, ...]
    gains: tuple[float, ...]
    speeds: tuple[float, ...]
    seed: int
    episodes: int


STEPS = (1 / 12, 1 / 6, 1 / 3, 2 / 3)
"""First steps of the foresight, as shares of the actuator's limit."""

SEARCHES = {
    "nav2d": Search(
        steps=STEPS,
        gains=(0.3, 0.6, 1.25, 2.5, 5.0, 10.0, 20.0, 40.0, 80.0, 160.0, 320.0, 640.0),
        speeds=(0.25, 0.5),
        seed=1024,
        episodes=128,
    ),
    "pusht": Search(
        steps=STEPS,
        gains=tuple(PIXEL * gain for gain in (4e3, 16e3, 64e3, 256e3, 1e6, 1e9)),
        speeds=tuple(PIXEL * speed for speed in (100.0, 200.0, 400.0, 800.0)),
        seed=1000,
        episodes=100,
    ),
}
LAWS = ("foresight", "set", "accumulate")
"""The action laws: the foresight, or one gradient a step that sets or changes the velocity."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is searched; what is left out is the task's."""
    parser.add_argument("--task", choices=SEARCHES, default="nav2d", help="default: nav2d")
    parser.add_argument(
        "--policies", nargs="+", required=True, metavar="NAME", help="policies of the task"
    )
    parser.add_argument("--steps", nargs="+", type=float, help="first steps of the foresight")
    parser.add_argument("--gains", nargs="+", type=float, help="of the other laws")
    parser.add_argument("--speeds", nargs="+", type=float, help="largest speeds, m/s")
    parser.add_argument(
        "--laws",
        nargs="+",
        choices=LAWS,
        default=["foresight"],
        help="action laws (default: foresight)",
    )
    parser.add_argument("--condition", metavar="NAME", help="of the task (default: its first)")
    add_compile_option(parser)
    parser.add_argument("--seed", type=int, help=f"first seed, {FIRST_SEED} or more")
    parser.add_argument("--episodes", type=int, help="seeds")
    parser.add_argument(
        "--horizon", type=int, metavar="STEPS", help="limit of an episode (default: the task's)"
    )
    add_option(parser, "--jobs", 1, "processes")
    parser.add_argument("--out", type=Path, required=True, help="folder of the results")


def run(arguments: argparse.Namespace) -> None:
    """Run what is missing in the folder and print the table of results, best first."""
    search = choose_search(arguments)
    task = load(arguments.task)
    candidates = list_candidates(task.name, arguments.policies, arguments.laws, search)
    candidates = compiled_as_asked(candidates, arguments.compile)

    config = configure(
        task,
        seed=search.seed,
        episodes=search.episodes,
        conditions=[arguments.condition] if arguments.condition else None,
        horizon=arguments.horizon,
    )
    with RunFolder.open(arguments.out, config) as folder:
        compare(task, candidates, folder, arguments.jobs)
        table = write_report(task, folder)
    print(table)


def choose_search(arguments: argparse.Namespace) -> Search:
    """Return the task's search with what the arguments say otherwise."""
    asked = {name: getattr(arguments, name) for name in Search._fields}
    given = {name: value for name, value in asked.items() if value is not None}

    search = SEARCHES[arguments.task]._replace(**given)
    if search.seed < FIRST_SEED:
        raise ComparisonError(
            f"--seed {search.seed}: seeds below {FIRST_SEED} are for reporting, not for tuning"
        )
    return search


def list_candidates(
    task: str, policies: list[str], laws: list[str], search: Search
) -> dict[str, Factory]:
    """Return what builds each policy with each law and speed, by a name that says which."""
    candidates = {}
    for policy, law, speed in product(policies, laws, search.speeds):
        for description, action_law in list_laws(law, search).items():
            name = f"{policy} {description} speed={speed:g}"
            candidates[name] = factory(task, policy, law=action_law, max_speed=speed)
    return candidates


def list_laws(law: str, search: Search) -> dict[str, ActionLaw]:
    """Return the action laws of one kind, by a name that says which."""
    if law == "foresight":
        return {f"foresight step={step:.3g}": Foresight(step=step) for step in search.steps}

    accumulate = law == "accumulate"
    return {
        f"{law} gain={gain:g}": DirectDescent(gain=gain, accumulate=accumulate)
        for gain in search.gains
    }


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)

if __name__ == "__main__":
    run_command(COMMAND)
