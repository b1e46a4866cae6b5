r"""Record successful episodes of AICON as a LeRobotDataset, to train a diffusion policy on.

Example: python scripts/collect_demos.py --episodes 200 --out runs/demos
         python scripts/train_diffusion.py --data runs/demos --out runs/diffusion
         python scripts/collect_demos.py --episodes 100 --task so101_pick_place:TASK \
           --correct runs/student/policy --out runs/corrections

Of pushT, the default, noise, starts and speed can be chosen; any other task that has a lesson is
recorded as it is. With --correct, a student acts first, and what AICON makes of where that led is
recorded. The same command goes on where a stopped run was. It needs LeRobot: make install.
"""

import argparse
from pathlib import Path

from aicon_baselines.agents.diffusion.configs import (
    OBSERVATIONS,
    AnyRecording,
    RecordingConfig,
    TaskRecordingConfig,
)
from aicon_baselines.cli.command_line import (
    RESUMABLE,
    Command,
    add_fields,
    add_option,
    fields_of,
    run_command,
)

FIELDS = {"episodes": "successful episodes", "seed": "first seed"}
OF_PUSHT = {"noises": "noise on actions, px", "near": "share of starts near the goal"}
OF_TASKS = {"longest": "steps that a student acts at most"}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is recorded."""
    add_option(parser, "--task", RecordingConfig.task, "the task, or MODULE:TASK of your own")
    add_fields(parser, RecordingConfig(), FIELDS)
    parser.add_argument("--out", type=Path, required=True, help="folder of the dataset")

    pusht = parser.add_argument_group("pushT")
    add_fields(pusht, RecordingConfig(), OF_PUSHT)
    pusht.add_argument(
        "--observe",
        nargs="+",
        choices=OBSERVATIONS,
        default=["keypoints"],
        help="default: keypoints",
    )

    tasks = parser.add_argument_group("other tasks")
    tasks.add_argument("--condition", metavar="NAME", help="of the task (default: the first)")
    tasks.add_argument("--correct", default="", metavar="FOLDER", help="policy of a student")
    add_fields(tasks, TaskRecordingConfig("", ""), OF_TASKS)


def run(arguments: argparse.Namespace) -> None:
    """Record what is missing and say what to do with it."""
    # Imported late: it loads torch, which reads the number of threads.
    from tqdm import tqdm

    from aicon_baselines.agents.diffusion.collection import collect

    config = configured(arguments)
    with tqdm(total=config.episodes, unit="episode", disable=None) as bar:

        def on_recorded(count: int) -> None:
            bar.update(count)

        collect(config, arguments.out, on_recorded)

    print(f"{config.episodes} episodes, saved in {arguments.out}; to train a diffusion policy:")
    print(f"python scripts/train_diffusion.py --data {arguments.out} --out runs/diffusion")


def configured(arguments: argparse.Namespace) -> AnyRecording:
    """What is recorded."""
    if arguments.task == RecordingConfig.task:
        observed = tuple(arguments.observe)
        chosen = fields_of(arguments, FIELDS | OF_PUSHT)
        return RecordingConfig(observations=observed, **chosen)

    from aicon_baselines.tasks import load

    condition = arguments.condition or load(arguments.task).conditions[0]
    chosen = fields_of(arguments, FIELDS | OF_TASKS)
    return TaskRecordingConfig(arguments.task, condition, student=arguments.correct, **chosen)


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)

if __name__ == "__main__":
    run_command(COMMAND)
