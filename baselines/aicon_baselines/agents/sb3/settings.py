"""What an agent was, or is to be, trained for."""

from dataclasses import dataclass
from typing import Any

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.tasks import load

ALGORITHMS = ("ppo", "sac")
"""What `train` trains; `Agent` also loads A2C, DDPG and TD3."""

_LOADABLE = (*ALGORITHMS, "a2c", "ddpg", "td3")
# Where the tasks differ. An episode of 1000 steps takes 50 s: many traps can be left in that, and most are met in it.
_DEFAULTS: dict[str, dict[str, Any]] = {
    "nav2d": {"horizon": 1000, "stack": 8, "reach": None, "discount": 0.995},
    "pusht": {"horizon": 300, "epochs": 10, "stack": 1, "reach": 100.0, "approach": 0.2, "discount": 0.99},
}


@dataclass(frozen=True)
class Settings:
    """What an agent was trained for.

    Attributes:
        task: Name of the task.
        algorithm: "ppo" or "sac".
        steps: Steps of all environments together.
        seed: Seed of the network, and of the environments: environment i starts with seed + i. Not below 1000, where
            the seeds are that results are reported on.
        envs: Number of environments.
        rollout: Steps of each environment between two updates of PPO.
        epochs: How often PPO learns from each rollout.
        horizon: Steps after which a training episode is cut.
        stack: Number of successive observations that the agent sees at once, zeros before the first one.
        reach: See `FromPusher`, px; None where the agent's actions are the environment's.
        approach: See `ShapedPush`; without meaning in navigation.
        discount: Discount factor of the return.
        normalized: Whether the readings were normalised, with statistics in `vecnormalize.pkl`.
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
        """Reject what cannot be trained or loaded."""
        if self.task not in _DEFAULTS:
            raise ComparisonError(f"unknown task {self.task!r}; valid tasks: {', '.join(_DEFAULTS)}")
        _check_algorithm(self.algorithm, _LOADABLE)
        for name in ("steps", "envs", "rollout", "epochs", "horizon", "stack"):
            if getattr(self, name) < 1:
                raise ComparisonError(f"{name} must be 1 or more, not {getattr(self, name)}")
        if self.seed < 1000:
            raise ComparisonError(f"the seed must be 1000 or more, not {self.seed}: results are reported on the others")


def settings(task: str, algorithm: str, steps: int, **options: Any) -> Settings:
    """Describe a training, with the task's defaults for what is None or not given."""
    _check_algorithm(algorithm, ALGORITHMS)
    given = {name: value for name, value in options.items() if value is not None}
    return Settings(load(task).name, algorithm, steps, **_DEFAULTS[task] | given)


def training_command(task: str, algorithm: str) -> str:
    """Return the command that trains an agent."""
    return f"python scripts/train_sb3.py --task {task} --algorithm {algorithm} --out FOLDER"


def _check_algorithm(name: str, valid: tuple[str, ...]) -> None:
    if name not in valid:
        raise ComparisonError(f"unknown algorithm {name!r}; valid algorithms: {', '.join(valid)}")
