"""Feed hostile readings to the policies, and check every command and every memory.

Each row of a batch reads numbers that no instrument should give: NaN, infinity, denormals, 1e308,
anything of 64 random bits, and now and then what is plausible, of sensors and of what is told of
them: ages, how long a step took, what was executed. Then come three good readings. Every
command must be finite and legal, and from the first good reading on every memory finite.

Example: python scripts/hostile_rows.py --task pusht --rows 1000000 --tensors --compile
"""

import argparse
import time
from collections.abc import Mapping
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from aicon_baselines.cli.command_line import Command, run_command
from aicon_torch import Policy, make_policy
from aicon_torch.models import arm_push, nav2d
from aicon_torch.models.pusht import PIXEL

HOSTILE_STEPS, GOOD_STEPS = 7, 3
"""How many hostile steps come in a row, and then how many good ones."""

SPECIAL = np.array(
    [np.nan, np.inf, -np.inf, 0.0, -0.0, 5e-324, 1e-300, 1e38, -1e38, 1e308, -1e308, 4.0, 1e6]
)

REACH_SPEED = 1.5
"""Largest speed of a joint in the task "reach", rad/s."""

FASTEST = {
    "nav2d": nav2d.Options().max_speed,
    "arm_push": arm_push.Options().limits.joint_speed,
}
"""Largest norm of a command, m/s and rad/s."""

Readings = dict[str, NDArray[Any]]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare whose readings, and how many."""
    parser.add_argument("--task", choices=tuple(GOOD), required=True)
    parser.add_argument("--rows", type=int, default=1_000_000, help="readings in all")
    parser.add_argument("--batch", type=int, default=10_000, help="of them at once")
    parser.add_argument("--seed", type=int, default=60_000)
    parser.add_argument("--tensors", action="store_true", help="tensors instead of arrays")
    parser.add_argument("--compile", action="store_true", help="the compiled policy")


def run(arguments: argparse.Namespace) -> None:
    """Run the steps, and print what was found."""
    torch.set_num_threads(1)
    policy = make_policy(arguments.task, **OPTIONS.get(arguments.task, dict)())
    if arguments.compile:
        policy = policy.compile()

    started = time.perf_counter()
    counts = feed(policy, arguments)
    counts["seconds"] = round(time.perf_counter() - started)
    print(f"{arguments.task}: " + ", ".join(f"{key} {value}" for key, value in counts.items()))
    if counts["illegal"] or counts["unhealed"]:
        raise SystemExit(1)


def feed(policy: Policy, arguments: argparse.Namespace) -> dict[str, int]:
    """Step through hostile and good readings; count what is not as it should be."""
    task, batch = arguments.task, arguments.batch
    generator = np.random.default_rng(arguments.seed)
    counts = {"rows": 0, "illegal": 0, "unhealed": 0}
    memory: Any = None
    step = 0
    while counts["rows"] < arguments.rows:
        is_good = step % (HOSTILE_STEPS + GOOD_STEPS) >= HOSTILE_STEPS
        readings = GOOD[task](generator, batch)
        if not is_good:
            readings = {key: hostile(value, generator) for key, value in readings.items()}

        given: Mapping[str, Any] = readings
        if arguments.tensors:
            given = {key: torch.as_tensor(value) for key, value in readings.items()}
        action, memory = policy.predict(given, memory)

        counts["rows"] += batch
        counts["illegal"] += int((~is_legal(task, np.asarray(action))).sum())
        if is_good:
            counts["unhealed"] += int((~is_finite(memory)).sum())
        step += 1
    return counts


def hostile(reading: NDArray[np.float64], generator: np.random.Generator) -> NDArray[np.float64]:
    """A reading of which every number is one of a kind that is drawn for each row."""
    count, size = reading.shape
    bits = generator.integers(0, 2**63, (count, size)) * 2 + generator.integers(0, 2, (count, size))
    kinds = np.stack(
        [
            bits.astype(np.uint64).view(np.float64),
            generator.choice(SPECIAL, (count, size)),
            10.0 ** generator.uniform(-10, 10, (count, size)),
            np.where(generator.uniform(size=(count, size)) < 0.1, np.nan, reading),
            reading,
        ]
    )
    chosen = generator.integers(0, len(kinds), count)
    picked: NDArray[np.float64] = kinds[chosen, np.arange(count)]
    return picked


def is_finite(memory: Mapping[str, torch.Tensor]) -> NDArray[np.bool_]:
    """Which rows of a memory are finite, ``(B,)``."""
    rows = len(next(iter(memory.values())))
    finite = torch.ones(rows, dtype=torch.bool)
    for value in memory.values():
        finite &= value.reshape(rows, -1).isfinite().all(-1)
    return finite.numpy()


def is_legal(task: str, action: NDArray[Any]) -> NDArray[np.bool_]:
    """Which commands ``(B, n)`` are finite and within their limits, ``(B,)``."""
    finite: NDArray[np.bool_] = np.isfinite(action).all(-1)
    if task == "pusht":
        on_board: NDArray[np.bool_] = finite & ((action >= 0) & (action <= 512)).all(-1)
        return on_board

    if task == "reach":
        within: NDArray[np.bool_] = finite & (np.abs(action) <= REACH_SPEED * (1 + 1e-6)).all(-1)
        return within

    limit = FASTEST[task]
    speed = np.linalg.norm(action.astype(np.float64), axis=-1)
    legal: NDArray[np.bool_] = finite & (speed <= limit * (1 + 1e-6))
    return legal


def _told(dt: float, count: int) -> Readings:
    """Readings that are prompt, in steps that take as long as usual."""
    return {"age": np.zeros((count, 1)), "elapsed": np.full((count, 1), dt)}


def _nav2d(generator: np.random.Generator, count: int) -> Readings:
    return {
        "bearing": generator.uniform(-np.pi, np.pi, (count, 1)),
        "range": generator.uniform(0.0, 20.0, (count, 1)),
        **_told(nav2d.Options().dt, count),
        "executed": generator.uniform(-0.3, 0.3, (count, 2)),
    }


def _pusht(generator: np.random.Generator, count: int) -> Readings:
    from aicon_torch.models.pusht import Options, rigid_object

    body = rigid_object(Options())
    places = generator.uniform(100.0, 400.0, (count, 2)) * PIXEL
    poses = np.concatenate((places, generator.uniform(-np.pi, np.pi, (count, 1))), axis=-1)
    keypoints = body.keypoints_at(torch.as_tensor(poses)).flatten(-2).numpy() / PIXEL
    return {
        "agent_pos": generator.uniform(0.0, 512.0, (count, 2)),
        "environment_state": keypoints,
        "age": np.zeros((count, 1)),
    }


def _arm_push(generator: np.random.Generator, count: int) -> Readings:
    from aicon_torch.models.arm_push import PANDA

    near, far = np.array([0.4, -0.2, -np.pi]), np.array([0.7, 0.2, np.pi])
    return {
        "q": generator.uniform(PANDA.chain.low, PANDA.chain.high, (count, 7)),
        "target": generator.uniform(near, far, (count, 3)),
        "object_pose": generator.uniform(near, far, (count, 3)),
        **_told(arm_push.Options().dt, count),
        "executed": generator.uniform(-0.1, 0.1, (count, 7)),
    }


def _reach(generator: np.random.Generator, count: int) -> Readings:
    return {
        "q": generator.uniform(-1.5, 1.5, (count, 6)),
        "target_position": generator.uniform(-0.6, 0.6, (count, 3)),
        "elapsed": np.full((count, 1), 0.02),
    }


def _ur5() -> dict[str, Any]:
    from aicon_baselines.tasks import load

    return load("reach").policy_options("ur5_position_home")


def _observed_pose() -> dict[str, Any]:
    return {"sensing": "pose"}


GOOD = {"nav2d": _nav2d, "pusht": _pusht, "arm_push": _arm_push, "reach": _reach}
OPTIONS = {"arm_push": _observed_pose, "reach": _ur5}

COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
