"""What demonstrations to record, and what a diffusion policy is trained with."""

import math
from dataclasses import dataclass
from typing import ClassVar

from aicon_baselines.evaluation.errors import ComparisonError, check_counts, check_known

OBSERVATIONS = ("keypoints", "pixels")
"""What a demonstration can show of the object; the pusher's position is always there."""

CHUNK_SIZE = 50
"""Number of seeds that are recorded as one batch."""

CHANNEL_GROUPS = 8
"""Channels of the U-Net are normalised in so many groups."""

_REPORTED_SEEDS = (range(1000), range(20_000, 21_000))  # no demonstration may use them


@dataclass(frozen=True)
class RecordingConfig:
    """What demonstrations of pushT to record; lengths are those of the environment, px.

    Attributes:
        episodes: Number of successful episodes.
        seed: First seed.
        noises: Standard deviations of the noise on the executed action, px; chunks of seeds take
            turns. What is recorded is the action that was sent, without the noise: how to go on
            from where the noise led.
        near: Share of the episodes that start with the object near its goal; see
            `demonstrations.py`.
        max_speed: Largest speed of the teacher, px/s. The default, with `smoothing`, makes
            demonstrations that last as long as human ones. At its own speed AICON solves the task
            in half the steps, but its targets jump, and a student that executes eight actions
            before it looks again learned nothing from them.
        smoothing: Time constant of the low-pass on the teacher's velocity, s.
        observations: Some of `OBSERVATIONS`.
        horizon: Steps within which an episode has to succeed.

    Raises:
        ComparisonError: Where this cannot be recorded.
    """

    task: ClassVar[str] = "pusht"

    episodes: int = 200
    seed: int = 100_000
    noises: tuple[float, ...] = (0.0, 2.0)
    near: float = 0.0
    max_speed: float = 250.0
    smoothing: float = 0.3
    observations: tuple[str, ...] = ("keypoints",)
    horizon: int = 300

    def __post_init__(self) -> None:
        check_counts(episodes=self.episodes, horizon=self.horizon)
        _check_seeds(self.seed, self.episodes)

        if not self.noises or not all(0.0 <= noise < math.inf for noise in self.noises):
            raise ComparisonError(f"noises must be one or more numbers >= 0, not {self.noises}")
        if not 0.0 <= self.near <= 1.0:
            raise ComparisonError(f"near must be a share between 0 and 1, not {self.near}")

        _check_positive(max_speed=self.max_speed, smoothing=self.smoothing)
        if not self.observations or set(self.observations) - set(OBSERVATIONS):
            raise ComparisonError(
                f"observations must be some of {', '.join(OBSERVATIONS)}, not {self.observations}"
            )


@dataclass(frozen=True)
class TaskRecordingConfig:
    """What demonstrations to record in any task that has a lesson.

    With a student they are corrections: it acts first while AICON watches, which takes over at some
    step. What AICON does from there is the demonstration.

    Attributes:
        task: Name of the task.
        condition: One of its conditions.
        episodes: Number of successful episodes.
        seed: First seed.
        student: Folder of the student's policy; empty for none.
        longest: Steps that the student acts at most; how many it is in an episode, its seed says.

    Raises:
        ComparisonError: Where this cannot be recorded.
    """

    task: str
    condition: str
    episodes: int = 200
    seed: int = 100_000
    student: str = ""
    longest: int = 40

    def __post_init__(self) -> None:
        check_counts(episodes=self.episodes, longest=self.longest)
        _check_seeds(self.seed, self.episodes)


AnyRecording = RecordingConfig | TaskRecordingConfig


@dataclass(frozen=True)
class TrainingConfig:
    """What to train.

    Where the defaults are not those of the published pushT policies, they are for few steps on a
    CPU.

    Attributes:
        steps: Number of gradient steps, at the end of which the cosine schedule has arrived at 0.
        observation: "keypoints" or "pixels", besides the pusher's position.
        down_dims: Channels of each stage of the U-Net.
        batch: Number of windows in a gradient step.
        learning_rate: Largest learning rate.
        horizon: Actions that are predicted at once.
        action_steps: How many of them are executed.
        shift: Standard deviations by which observations are raised. Each block of the U-Net passes
            them through Mish first, which is flat below 0 and takes the same values above -1.2 as
            below: a network would hardly tell apart what lies below the mean.
        seed: Seed of the network, the order of the data and the noise.

    Raises:
        ComparisonError: Where this cannot be trained.
    """

    steps: int
    observation: str = "keypoints"
    down_dims: tuple[int, ...] = (64, 128, 256)
    batch: int = 64
    learning_rate: float = 1e-3
    horizon: int = 16
    action_steps: int = 8
    shift: float = 2.0
    seed: int = 100_000

    def __post_init__(self) -> None:
        check_counts(steps=self.steps, batch=self.batch)
        check_counts(horizon=self.horizon, action_steps=self.action_steps)
        check_known("observation", self.observation, OBSERVATIONS)
        _check_positive(learning_rate=self.learning_rate)
        if not math.isfinite(self.shift) or self.seed < 0:
            raise ComparisonError(
                f"shift must be finite and seed 0 or more, not {self.shift} and {self.seed}"
            )

        # The first action belongs to the observation before the newest, and is over.
        if self.action_steps > self.horizon - 1:
            raise ComparisonError(
                f"action_steps must be at most {self.horizon - 1}, not {self.action_steps}"
            )

        # Each stage of the U-Net halves the sequence.
        divisor = 2 ** len(self.down_dims)
        if not self.down_dims or self.horizon % divisor:
            raise ComparisonError(
                f"horizon must be a multiple of {divisor}, 2 for each of down_dims, "
                f"not {self.horizon}"
            )
        if any(channels < 1 or channels % CHANNEL_GROUPS for channels in self.down_dims):
            raise ComparisonError(
                f"down_dims must be multiples of {CHANNEL_GROUPS}, not {self.down_dims}"
            )


def _check_positive(**values: float) -> None:
    """Refuse what is not a positive number."""
    for name, value in values.items():
        if not 0.0 < value < math.inf:
            raise ComparisonError(f"{name} must be positive, not {value}")


def _check_seeds(first: int, episodes: int) -> None:
    """Reject seeds that results are reported on, if every tenth episode is a success."""
    seeds = range(first, first + 10 * episodes + CHUNK_SIZE)

    for reported in _REPORTED_SEEDS:
        overlaps = seeds.start < reported.stop and reported.start < seeds.stop
        if overlaps or first < 0:
            raise ComparisonError(
                "seed must leave out 0 to 999 and 20000 to 20999, which results are reported "
                f"on, not {first}: take 100000"
            )
