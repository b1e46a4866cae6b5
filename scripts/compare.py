"""Compare policies on the episodes of a task: one row per episode, a summary and the success over time.

Example: python scripts/compare.py --task nav2d --policies aicon steepest --episodes 100 --jobs 2 --out runs/nav2d

The same command goes on where a stopped run was; another one with other policies adds them to the same folder.
"""

import argparse
import os
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")  # read when torch is loaded, here and in the workers

from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.evaluation.backends import BACKENDS
from aicon_baselines.evaluation.comparison import compare
from aicon_baselines.evaluation.config import configure
from aicon_baselines.agents.registry import Factory, compiled, diffusion_policy, factory, saved_agent
from aicon_baselines.evaluation.report import write_report
from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.evaluation.tables import list_failures
from aicon_baselines.evaluation.task import Task
from aicon_baselines.tasks import load


def main() -> None:
    """Parse the arguments, run what is missing, save and print the results."""
    parser = _parser()
    arguments = parser.parse_args()
    try:
        table = _run(arguments)
    except ComparisonError as error:
        parser.error(str(error))
    except KeyboardInterrupt:
        parser.exit(130, "\nstopped; the same command goes on from here\n")
    print(table)
    print(f"\nsaved in {arguments.out}: episodes.csv, summary.json, success_curve.png")


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--task", required=True, help="name of the task: nav2d, pusht or panda_push")
    parser.add_argument("--policies", nargs="+", required=True, metavar="NAME", help="policies to compare")
    parser.add_argument(
        "--compile",
        action="store_true",
        help="compile them: the rows of NAME are NAME_compiled (panda_push: always, as NAME)",
    )
    parser.add_argument(
        "--sb3-path", nargs="+", default=[], type=Path, metavar="FOLDER", help="agents that 'sb3' in --policies means"
    )
    parser.add_argument("--sampled", action="store_true", help="draw the actions of these agents, as in training")
    parser.add_argument(
        "--diffusion-path",
        nargs="+",
        default=[],
        metavar="FOLDER",
        help="what 'diffusion' in --policies means: folders, or names such as lerobot/diffusion_pusht",
    )
    parser.add_argument("--sampler", choices=("DDPM", "DDIM"), help="of diffusion policies (default: their own)")
    parser.add_argument("--inference-steps", type=int, metavar="STEPS", help="of the sampler (default: their own)")
    parser.add_argument("--episodes", type=int, default=100, help="seeds, per condition and repeat (default: 100)")
    parser.add_argument("--seed", type=int, default=0, help="first seed (default: 0)")
    parser.add_argument("--repeats", type=int, default=1, help="runs of each seed with other noise (default: 1)")
    parser.add_argument("--conditions", nargs="+", metavar="NAME", help="variants of the task (default: the first)")
    parser.add_argument("--maps", nargs="+", metavar="NAME", help="classes of maps (default: all)")
    parser.add_argument("--horizon", type=int, metavar="STEPS", help="limit of an episode (default: the task's)")
    parser.add_argument("--out", type=Path, required=True, help="folder of the results")
    parser.add_argument("--jobs", type=int, default=1, help="processes (default: 1)")
    parser.add_argument("--backend", choices=BACKENDS, default="loky", help="where they run (default: loky)")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="a running dask scheduler, for --backend dask")
    return parser


def _run(arguments: argparse.Namespace) -> str:
    """Run what is missing in the folder and return the table of results, and which episodes failed."""
    task = load(arguments.task)
    policies = _policies(task, arguments)
    config = configure(
        task,
        seed=arguments.seed,
        episodes=arguments.episodes,
        repeats=arguments.repeats,
        conditions=arguments.conditions,
        maps=arguments.maps,
        horizon=arguments.horizon,
    )
    folder = RunFolder(arguments.out, config)
    compare(task, policies, folder, arguments.jobs, arguments.backend, arguments.scheduler)
    table, failures = write_report(task, folder), list_failures(folder.rows(), task)
    return f"{table}\n\n{failures}" if failures else table


def _policies(task: Task, arguments: argparse.Namespace) -> dict[str, Factory]:
    """Return what builds each policy, by the name it gets in the rows."""
    policies: dict[str, Factory] = {}
    for name in arguments.policies:
        if name == "sb3":
            policies |= [saved_agent(task.name, folder, arguments.sampled) for folder in arguments.sb3_path]
        elif name == "diffusion":
            options = arguments.sampler, arguments.inference_steps
            policies |= [diffusion_policy(task.name, source, *options) for source in arguments.diffusion_path]
        elif task.compiles:
            policies[name] = compiled(factory(task.name, name))
        elif arguments.compile:
            policies[f"{name}_compiled"] = compiled(factory(task.name, name))
        else:
            policies[name] = factory(task.name, name)
    for name, paths, script in (
        ("sb3", arguments.sb3_path, f"train_sb3.py --task {task.name} --out FOLDER"),
        ("diffusion", arguments.diffusion_path, "train_diffusion.py --data DEMONSTRATIONS --out FOLDER"),
    ):
        if (name in arguments.policies) != bool(paths):
            raise ComparisonError(
                f"the policy {name!r} and --{name}-path FOLDER belong together; train one: python scripts/{script}"
            )
    return policies


if __name__ == "__main__":
    main()
