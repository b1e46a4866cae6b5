"""What an agent was, or is to be, trained for."""

import math
from dataclasses import dataclass
from typing import Any, Self

from aicon_baselines.evaluation.errors import ComparisonError, check_counts, check_known

ALGORITHMS = ("ppo", "sac")
"""What `train` trains; `Agent` also loads A2C, DDPG and TD3."""

_LOADABLE_ALGORITHMS = (*ALGORITHMS, "a2c", "ddpg", "td3")

# Where the tasks differ. In navigation, 1000 steps are 50 s: enough to meet most traps and to
# leave many of them.
TASK_DEFAULTS: dict[str, dict[str, Any]] = {
    "nav2d": {
        "horizon": 1000,
        "stack": 8,
        "reach": None,
        "discount": 0.995,
    },
    "pusht": {
        "horizon": 300,
        "epochs": 10,
        "stack": 1,
        "reach": 100.0,
        "approach": 0.2,
        "discount": 0.99,
    },
}


@dataclass(frozen=True)
class TrainingConfig:
    """What an agent is trained for.

    Attributes:
        task: Name of the task.
        algorithm: "ppo" or "sac".
        steps: Steps of all environments together.
        seed: Seed of the network, and of the environments: environment i starts with seed + i. At
            least 1000, because results are reported on the seeds below.
        envs: Number of environments.
        rollout: Steps of each environment between two updates of PPO.
        epochs: How often PPO learns from each rollout.
        horizon: Steps after which a training episode is cut.
        stack: Number of successive observations that the agent sees at once, zeros before the
            first one.
        reach: See `PusherFrame`, px; None where the agent's actions are the environment's.
        approach: See `ShapedReward`; without meaning in navigation.
        discount: Discount factor of the return.
        normalized: Whether the readings were normalised, with statistics in `vecnormalize.pkl`.

    Raises:
        ComparisonError: Where this cannot be trained or loaded.
    """

    task: str
    algorithm: str
    steps: int
    seed: int = 10_000
    envs: int = 8
    rollout: int = 512
    epochs: int = 5
    horizon: int = 1000
    stack: int = 1
    reach: float | None = None
    approach: float = 0.0
    discount: float = 0.99
    normalized: bool = True

    def __post_init__(self) -> None:
        check_known("task", self.task, TASK_DEFAULTS)
        check_known("algorithm", self.algorithm, _LOADABLE_ALGORITHMS)
        check_counts(steps=self.steps, envs=self.envs, rollout=self.rollout)
        check_counts(epochs=self.epochs, horizon=self.horizon, stack=self.stack)

        if not 0.0 < self.discount <= 1.0:
            raise ComparisonError(f"discount must be in (0, 1], not {self.discount}")
        if self.reach is not None and not 0.0 < self.reach < math.inf:
            raise ComparisonError(f"reach must be positive, or None, not {self.reach}")
        if not 0.0 <= self.approach < math.inf:
            raise ComparisonError(f"approach must be 0 or more, not {self.approach}")

        if self.seed < 1000:
            raise ComparisonError(
                f"the seed must be 1000 or more, not {self.seed}: "
                "results are reported on the others"
            )

    @classmethod
    def for_task(cls, task: str, algorithm: str, steps: int, **options: Any) -> Self:
        """Describe a training, with the task's defaults for what is None or not given.

        Args:
            task: Name of the task.
            algorithm: One of `ALGORITHMS`.
            steps: Steps of all environments together.
            **options: Other attributes.
        """
        check_known("algorithm", algorithm, ALGORITHMS)
        check_known("task", task, TASK_DEFAULTS)

        given = {name: value for name, value in options.items() if value is not None}
        return cls(task, algorithm, steps, **TASK_DEFAULTS[task] | given)


def training_command(task: str, algorithm: str) -> str:
    """Return the command that trains an agent."""
    return f"python scripts/train_sb3.py --task {task} --algorithm {algorithm} --out FOLDER"
