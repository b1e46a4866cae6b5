"""What a diffusion policy is trained with."""

from dataclasses import dataclass

from aicon_baselines.agents.diffusion.recording_config import OBSERVATIONS
from aicon_baselines.evaluation.errors import ComparisonError

PREDICTIONS = ("sample", "epsilon")
NORMALIZATIONS = ("MEAN_STD", "MIN_MAX")


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
        warmup: Steps until it is reached.
        horizon: Actions that are predicted at once.
        action_steps: How many of them are executed.
        kernel: Size of the U-Net's convolutions; 5 in the published policies.
        prediction: What the network predicts, "sample", the actions, or "epsilon", the noise in
            them. Noise hides the actions at most levels, where a network that predicts it learns
            little of how actions follow from observations; the published policies had 200,000 steps
            to do so.
        normalization: Of the observations, "MEAN_STD" or "MIN_MAX", as in the published policies.
            They reach the network through linear maps, which learn faster from values around 1.
        shift: Standard deviations by which observations are raised, with "MEAN_STD" only. Each
            block of the U-Net passes them through Mish first, which is flat below 0 and takes the
            same values above -1.2 as below: a network would hardly tell apart what lies below the
            mean.
        crop: Side of the part of a picture that is seen; in training at a random place.
        seed: Seed of the network, the order of the data and the noise.

    Raises:
        ComparisonError: Where this cannot be trained.
    """

    steps: int
    observation: str = "keypoints"
    down_dims: tuple[int, ...] = (64, 128, 256)
    batch: int = 64
    learning_rate: float = 1e-3
    warmup: int = 200
    horizon: int = 16
    action_steps: int = 8
    kernel: int = 3
    prediction: str = "sample"
    normalization: str = "MEAN_STD"
    shift: float = 2.0
    crop: int = 84
    seed: int = 100_000

    def __post_init__(self) -> None:
        for name in ("steps", "batch", "horizon", "action_steps", "kernel", "crop"):
            count = getattr(self, name)
            if count < 1:
                raise ComparisonError(f"{name} must be 1 or more, not {count}")

        _check_name("prediction", self.prediction, PREDICTIONS)
        _check_name("normalization", self.normalization, NORMALIZATIONS)
        if self.shift and self.normalization != "MEAN_STD":
            raise ComparisonError(
                f"shift needs normalization MEAN_STD: take shift 0, not {self.shift}"
            )
        _check_name("observation", self.observation, OBSERVATIONS)

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


def _check_name(kind: str, name: str, valid: tuple[str, ...]) -> None:
    if name not in valid:
        raise ComparisonError(f"unknown {kind} {name!r}; valid: {', '.join(valid)}")
