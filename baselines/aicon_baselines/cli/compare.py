"""Compare policies on the episodes of a task: rows, a summary and the success over time.

Example: aicon compare --task nav2d --policies aicon steepest --jobs 2 --out runs/nav2d

The same command goes on where a stopped run was; another one with other policies, and the same
conditions and seeds, adds them to the same folder.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

from aicon_baselines.agents.registry import (
    diffusion_policy,
    factory,
    own_policy,
    saved_agent,
)
from aicon_baselines.agents.shipped import PUBLISHED_DIFFUSION, shipped_folder
from aicon_baselines.cli.command_line import RESUMABLE, Command, add_option
from aicon_baselines.cli.compiling import add_compile_option, compiled_as_asked
from aicon_baselines.evaluation.backends import BACKENDS
from aicon_baselines.evaluation.config import configure
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.predictor import Factory
from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.evaluation.tables import list_failures
from aicon_baselines.evaluation.task import Task
from aicon_baselines.tasks import choices, load


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the policies, the episodes and how to run them."""
    parser.add_argument("--task", required=True, metavar="TASK", help=choices())
    _add_policies(parser.add_argument_group("policies"))
    _add_episodes(parser.add_argument_group("episodes"))
    _add_execution(parser.add_argument_group("execution"))


def run(arguments: argparse.Namespace) -> None:
    """Run what is missing in the folder; print the table of results, and which episodes failed."""
    task = load(arguments.task)

    from aicon_baselines.evaluation.comparison import compare
    from aicon_baselines.evaluation.report import write_report

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

    # What is in the folder already is not run again.
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
    _check_paths("sb3", arguments.sb3_path, arguments.policies)
    _check_paths("diffusion", arguments.diffusion_path, arguments.policies)

    policies: dict[str, Factory] = {}
    of_task: dict[str, Factory] = {}
    for name in arguments.policies:
        if name == "sb3":
            policies |= _saved_agents(task, arguments)
        elif name == "diffusion":
            policies |= _diffusion_policies(task, arguments)
        elif ":" in name:
            policies[name] = own_policy(name)
        else:
            of_task[name] = factory(task.name, name)

    return compiled_as_asked(of_task, arguments.compile) | policies


def _saved_agents(task: Task, arguments: argparse.Namespace) -> dict[str, Factory]:
    """Return what loads each agent of stable-baselines3; without a folder, the one that we ship."""
    ways = (arguments.sampled, arguments.trust)
    if not arguments.sb3_path:
        _, build = saved_agent(task.name, shipped_folder("sb3", task.name), *ways)
        return {"ppo_sampled" if arguments.sampled else "ppo": build}

    return dict(saved_agent(task.name, folder, *ways) for folder in arguments.sb3_path)


def _diffusion_policies(task: Task, arguments: argparse.Namespace) -> dict[str, Factory]:
    """Return what loads each diffusion policy; without a folder, the one that we ship."""
    ways = (arguments.sampler, arguments.inference_steps)
    if not arguments.diffusion_path:
        source = str(shipped_folder("diffusion", task.name))
        label, build = diffusion_policy(task.name, source, *ways)
        return {"diffusion" if ways == (None, None) else label: build}

    return dict(diffusion_policy(task.name, source, *ways) for source in arguments.diffusion_path)


def _check_paths(name: str, paths: Sequence[object], policies: Sequence[str]) -> None:
    """Refuse the folder of a trained policy without its name."""
    if paths and name not in policies:
        raise ComparisonError(
            f"--{name}-path says which policy {name!r} means: add {name} to --policies"
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

    add_compile_option(group)

    group.add_argument(
        "--sb3-path",
        nargs="+",
        type=Path,
        default=[],
        metavar="FOLDER",
        help="what 'sb3' in --policies means: folders of trained agents (default: the PPO that is "
        "shipped)",
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
        f"hub, such as {PUBLISHED_DIFFUSION} (default: the student that is shipped)",
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
    add_option(group, "--episodes", 100, "seeds, per condition and repeat")
    add_option(group, "--seed", 0, "first seed")
    add_option(group, "--repeats", 1, "runs of each seed with other noise")

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
    add_option(group, "--jobs", 1, "processes")
    group.add_argument(
        "--backend", choices=BACKENDS, default="loky", help="where they run (default: loky)"
    )
    group.add_argument(
        "--scheduler", metavar="ADDRESS", help="a running dask scheduler, for --backend dask"
    )


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)
