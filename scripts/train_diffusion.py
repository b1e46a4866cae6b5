r"""Train LeRobot's diffusion policy on demonstrations, to be compared by `aicon compare`.

Example: python scripts/train_diffusion.py --data runs/demos --steps 20000 --out runs/diffusion
         aicon compare --task pusht --policies aicon diffusion \
           --diffusion-path runs/diffusion/policy --out runs/pusht

The same command goes on where a stopped run was saved last, and one with other --steps to that
number of them; with other --data a copy of its folder goes on with these. It needs LeRobot: make
install.
"""

import argparse
from functools import partial
from pathlib import Path

from aicon_baselines.agents.diffusion.configs import OBSERVATIONS, TrainingConfig
from aicon_baselines.cli.command_line import Command, add_fields, add_option, fields_of, run_command

FIELDS = {
    # The network.
    "down_dims": "channels of its stages",
    "horizon": "actions predicted at once",
    "action_steps": "executed before it looks again",
    # What it learns.
    "shift": "of observations, σ",
    # How it learns.
    "steps": "gradient steps",
    "seed": "of network, order and noise",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is trained, how, and what is done with it at the end."""
    parser.add_argument(
        "--data", type=Path, nargs="+", required=True, help="folders of datasets, together"
    )
    parser.add_argument("--out", type=Path, required=True, help="folder of the training")
    parser.add_argument(
        "--observe", choices=OBSERVATIONS, default="keypoints", help="default: keypoints"
    )
    add_fields(parser, TrainingConfig(steps=20_000), FIELDS)

    add_option(parser, "--device", "cpu", "cpu or cuda")
    add_option(parser, "--checkpoint", 1000, "steps between saves")
    parser.add_argument(
        "--stop-after", type=float, metavar="MINUTES", help="save and stop then, to go on later"
    )

    parser.add_argument(
        "--export", type=Path, metavar="FOLDER", help="copy it there in half precision at the end"
    )
    parser.add_argument("--sampler", choices=("DDPM", "DDIM"), help="of the copy (default: DDPM)")
    parser.add_argument("--inference-steps", type=int, help="of its sampler (default: 100)")


def run(arguments: argparse.Namespace) -> None:
    """Train what is missing and say what to do with it."""
    # Imported late: they load torch, which reads the number of threads.
    from aicon_baselines.agents.diffusion.export import export
    from aicon_baselines.agents.diffusion.training import POLICY, train

    config = TrainingConfig(observation=arguments.observe, **fields_of(arguments, FIELDS))
    steps = train(
        config,
        arguments.data,
        arguments.out,
        device=arguments.device,
        checkpoint=arguments.checkpoint,
        stop_after=arguments.stop_after,
        report=partial(print, flush=True),
    )
    if arguments.export and steps == config.steps:
        export(arguments.out, arguments.export, arguments.sampler, arguments.inference_steps)

    print(f"{steps:,} steps, saved in {arguments.out / POLICY}; to compare it:")
    print(
        "aicon compare --task TASK --policies aicon diffusion "
        f"--diffusion-path {arguments.out / POLICY} --out runs/compared"
    )


COMMAND = Command(
    __doc__, add_arguments, run, "stopped; the same command goes on from the last checkpoint"
)

if __name__ == "__main__":
    run_command(COMMAND)
