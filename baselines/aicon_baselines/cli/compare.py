"""Compare policies on the episodes of a task: rows, a summary and the success over time.

Example: aicon compare --task nav2d --policies aicon steepest --jobs 2 --out runs/nav2d

The same command goes on where a stopped run was; another one with other policies adds them to the
same folder.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

from aicon_baselines.agents.registry import (
    compiled,
    diffusion_policy,
    factory,
    own_policy,
    saved_agent,
)
from aicon_baselines.cli.command_line import RESUMABLE, Command
from aicon_baselines.evaluation.backends import BACKENDS
from aicon_baselines.evaluation.comparison import compare
from aicon_baselines.evaluation.config import configure
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.predictor import Factory
from aicon_baselines.evaluation.report import write_report
from aicon_baselines.evaluation.row import COMPILED
from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.evaluation.tables import list_failures
from aicon_baselines.evaluation.task import Task
from aicon_baselines.tasks import load


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the policies, the episodes and how to run them."""
    parser.add_argument("--task", required=True, help="name of the task; see aicon list")
    _add_policies(parser.add_argument_group("policies"))
    _add_episodes(parser.add_argument_group("episodes"))
    _add_execution(parser.add_argument_group("execution"))


def run(arguments: argparse.Namespace) -> None:
    """Run what is missing in the folder; print the table of results, and which episodes failed."""
    task = load(arguments.task)
    policies = choose_policies(task, arguments)
    config = configure(
        task,
        seed=arguments.seed,
        episodes=arguments.episodes,
        repeats=arguments.repeats,
        conditions=arguments.conditions,
        maps=arguments.maps,
        horizon=arguments.horizon,
    )

    with RunFolder.open(arguments.out, config) as folder:
        compare(task, policies, folder, arguments.jobs, arguments.backend, arguments.scheduler)
        table = write_report(task, folder)
        failures = list_failures(folder.rows(), task)

    print(table)
    if failures:
        print(f"\n{failures}")
    print(f"\nsaved in {arguments.out}: episodes.csv, summary.json, success_curve.png")


def choose_policies(task: Task, arguments: argparse.Namespace) -> dict[str, Factory]:
    """Return what builds each policy, by the name it gets in the rows."""
    policies: dict[str, Factory] = {}
    for name in arguments.policies:
        if name == "sb3":
            for folder in arguments.sb3_path:
                label, build = saved_agent(task.name, folder, arguments.sampled, arguments.trust)
                policies[label] = build

        elif name == "diffusion":
            for source in arguments.diffusion_path:
                label, build = diffusion_policy(
                    task.name, source, arguments.sampler, arguments.inference_steps
                )
                policies[label] = build

        elif ":" in name:
            policies[name] = own_policy(name)

        elif task.compiles:
            policies[name] = compiled(factory(task.name, name))
        elif arguments.compile:
            policies[name + COMPILED] = compiled(factory(task.name, name))
        else:
            policies[name] = factory(task.name, name)

    _check_paths("sb3", arguments.sb3_path, arguments, f"train_sb3.py --task {task.name}")
    _check_paths(
        "diffusion",
        arguments.diffusion_path,
        arguments,
        "train_diffusion.py --data DEMONSTRATIONS",
    )
    return policies


def _check_paths(
    name: str, paths: Sequence[object], arguments: argparse.Namespace, script: str
) -> None:
    """Refuse the name of a trained policy without its folder, and the folder without the name."""
    if (name in arguments.policies) != bool(paths):
        raise ComparisonError(
            f"the policy {name!r} and --{name}-path FOLDER belong together; train one: "
            f"python scripts/{script} --out FOLDER"
        )


def _add_policies(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--policies",
        nargs="+",
        required=True,
        metavar="NAME",
        help="policies of the task; trained ones: sb3, diffusion; in pusht a planner: mppi; your "
        "own: MODULE:FUNCTION, a function of the condition that returns something with predict",
    )

    group.add_argument(
        "--compile",
        action="store_true",
        help="compile them: the rows of NAME are NAME_compiled (panda_push: always, as NAME)",
    )

    group.add_argument(
        "--sb3-path",
        nargs="+",
        type=Path,
        default=[],
        metavar="FOLDER",
        help="what 'sb3' in --policies means: folders of trained agents",
    )
    group.add_argument(
        "--sampled", action="store_true", help="draw the actions of these agents, as in training"
    )
    group.add_argument(
        "--trust",
        action="store_true",
        help="load agents that hold more than numbers: any code in their files runs, so know where "
        "they come from",
    )

    group.add_argument(
        "--diffusion-path",
        nargs="+",
        default=[],
        metavar="FOLDER",
        help="what 'diffusion' in --policies means: folders, or OWNER/REPOSITORY@COMMIT of the "
        "hub, with a repository such as lerobot/diffusion_pusht",
    )
    group.add_argument(
        "--sampler",
        choices=("DDPM", "DDIM"),
        help="of diffusion policies (default: their own)",
    )
    group.add_argument(
        "--inference-steps",
        type=int,
        metavar="STEPS",
        help="of the sampler (default: their own)",
    )


def _add_episodes(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--episodes",
        type=int,
        default=100,
        help="seeds, per condition and repeat (default: 100)",
    )
    group.add_argument("--seed", type=int, default=0, help="first seed (default: 0)")
    group.add_argument(
        "--repeats",
        type=int,
        default=1,
        help="runs of each seed with other noise (default: 1)",
    )

    group.add_argument(
        "--conditions",
        nargs="+",
        metavar="NAME",
        help="variants of the task (default: the first)",
    )
    group.add_argument("--maps", nargs="+", metavar="NAME", help="classes of maps (default: all)")
    group.add_argument(
        "--horizon",
        type=int,
        metavar="STEPS",
        help="limit of an episode (default: the task's)",
    )


def _add_execution(group: argparse._ArgumentGroup) -> None:
    group.add_argument("--out", type=Path, required=True, help="folder of the results")
    group.add_argument("--jobs", type=int, default=1, help="processes (default: 1)")
    group.add_argument(
        "--backend", choices=BACKENDS, default="loky", help="where they run (default: loky)"
    )
    group.add_argument(
        "--scheduler", metavar="ADDRESS", help="a running dask scheduler, for --backend dask"
    )


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)
