"""What changes during training: network, averaged weights, optimiser and random numbers."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from pickle import UnpicklingError
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from aicon_baselines.agents.diffusion.checkpoint import save
from aicon_baselines.agents.diffusion.configs import CHANNEL_GROUPS, TrainingConfig
from aicon_baselines.agents.diffusion.dataset import Frames, shuffled_batches
from aicon_baselines.agents.diffusion.lerobot_names import (
    ACTION,
    KEYPOINTS,
    PIXELS,
    STATE,
    describe_features,
    import_lerobot,
)
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.files import replacing

# The published pushT policy's; all is named, because LeRobot's defaults differ between versions.
_OBSERVATIONS = {
    "n_obs_steps": 2,
    # Windows may begin near an episode's end, whose success is what matters most; what lies beyond
    # is no action.
    "drop_n_last_frames": 0,
    "do_mask_loss_for_padding": True,
}
_IMAGE_ENCODER = {
    "crop_shape": (84, 84),
    "crop_is_random": True,
    "vision_backbone": "resnet18",
    "pretrained_backbone_weights": None,
    "use_group_norm": True,
    "use_separate_rgb_encoder_per_camera": False,
    "spatial_softmax_num_keypoints": 32,
}
_NETWORK = {
    "kernel_size": 3,  # 5 in the published policies
    "n_groups": CHANNEL_GROUPS,
    "diffusion_step_embed_dim": 128,
    "use_film_scale_modulation": True,
}
_NOISE = {
    "noise_scheduler_type": "DDPM",
    "num_train_timesteps": 100,
    "beta_schedule": "squaredcos_cap_v2",
    "beta_start": 0.0001,
    "beta_end": 0.02,
    "clip_sample": True,
    "clip_sample_range": 1.0,
    # The network predicts the actions. Noise hides them at most levels, where a network that
    # predicts it learns little of how actions follow from observations; the published policies had
    # 200,000 steps to do so.
    "prediction_type": "sample",
}
_OPTIMIZER = {
    "optimizer_betas": (0.95, 0.999),
    "optimizer_eps": 1e-8,
    "optimizer_weight_decay": 1e-6,
    "scheduler_name": "cosine",
    "scheduler_warmup_steps": 200,
}


def make_policy_config(
    config: TrainingConfig, features: Mapping[str, Mapping[str, Any]], device: str = "cpu"
) -> Any:
    """Return LeRobot's `DiffusionConfig` of a training.

    Args:
        config: The training.
        features: The features of the dataset, as LeRobot describes them.
        device: "cpu" or "cuda".
    """
    inputs = describe_features({name: _shape_in_policy(name, features[name]) for name in features})
    outputs = {ACTION: inputs.pop(ACTION)}
    encoder = _IMAGE_ENCODER | ({} if config.observation == "pixels" else {"crop_shape": None})

    configuration = import_lerobot("policies.diffusion.configuration_diffusion")
    return configuration.DiffusionConfig(
        input_features=inputs,
        output_features=outputs,
        normalization_mapping=_normalization_modes(),
        device=device,
        push_to_hub=False,
        horizon=config.horizon,
        n_action_steps=config.action_steps,
        down_dims=config.down_dims,
        optimizer_lr=config.learning_rate,
        **_OBSERVATIONS,
        **encoder,
        **_NETWORK,
        **_NOISE,
        **_OPTIMIZER,
    )


def _normalization_modes() -> dict[str, Any]:
    """Return how each type of feature is normalised.

    Observations reach the network through linear maps, which learn faster from values around 1.
    """
    modes = import_lerobot("configs.types").NormalizationMode
    return {
        "VISUAL": modes.MEAN_STD,
        "STATE": modes.MEAN_STD,
        "ENV": modes.MEAN_STD,  # missing in LeRobot's default: they would come in px
        "ACTION": modes.MIN_MAX,
    }


def _shape_in_policy(name: str, feature: Mapping[str, Any]) -> tuple[int, ...]:
    """Return the shape of a dataset's feature in a policy, where pictures have channels first."""
    if name == PIXELS:
        height, width, channels = feature["shape"]
        return channels, height, width
    return tuple(feature["shape"])


_MAX_GRADIENT_NORM = 10.0
_PADDED = "action_is_pad"  # LeRobot's name for actions beyond an episode's end


class Learner:
    """Network, averaged weights, optimiser and random numbers: what changes during training.

    Args:
        config: What is trained.
        frames: The demonstrations.
        device: Where the network is.

    Attributes:
        step: Number of gradient steps taken.
    """

    def __init__(self, config: TrainingConfig, frames: Frames, device: torch.device) -> None:
        self.step = 0
        self._frames = frames
        self._device = device

        # 1. The network, and what stands before and after it.
        torch.manual_seed(config.seed)
        policy_config = make_policy_config(config, frames.features, str(device))
        modeling = import_lerobot("policies.diffusion.modeling_diffusion")
        self._policy: Any = modeling.DiffusionPolicy(policy_config)
        self._policy.to(device).train()
        self._preprocess, self._postprocess = import_lerobot(
            "policies.factory"
        ).make_pre_post_processors(
            policy_config,
            dataset_stats=_lower_means(frames.statistics, config.shift),
        )

        # 2. What changes it.
        self._averaged_weights = _average_weights(self._policy, device)
        self._optimizer = _make_optimizer(self._policy, config)
        schedule = policy_config.get_scheduler_preset()
        self._schedule = schedule.build(self._optimizer, config.steps)

        # 3. What it learns from.
        self._offsets = {name: policy_config.observation_delta_indices for name in frames.columns}
        self._offsets[ACTION] = policy_config.action_delta_indices
        self._batches: Iterator[NDArray[np.int64]] = shuffled_batches(
            len(frames), config.batch, config.seed
        )

    @property
    def learning_rate(self) -> float:
        """The learning rate of the next step."""
        return float(self._schedule.get_last_lr()[0])

    def advance(self) -> float:
        """Take one gradient step and return its loss.

        Raises:
            ComparisonError: If the loss is no finite number, from which there is nothing to learn.
        """
        batch = self._preprocess(self._load_batch(next(self._batches)))
        loss, _ = self._policy(batch)
        if not loss.isfinite():
            raise ComparisonError(
                f"the loss of step {self.step + 1} is {float(loss.detach())}: take a smaller "
                "learning rate, or demonstrations without NaN; what was saved before stays"
            )

        loss.backward()
        torch.nn.utils.clip_grad_norm_(self._policy.parameters(), _MAX_GRADIENT_NORM)
        self._optimizer.step()
        self._schedule.step()
        self._optimizer.zero_grad()

        self._averaged_weights.step(self._policy.parameters())
        self.step += 1
        return float(loss.detach())  # a number to report, no part of a graph

    def save(self, file: Path, folder: Path) -> None:
        """Save the policy with averaged weights, and what training goes on from.

        The latter comes last: a training that is killed meanwhile saves both once more.

        Args:
            file: File of the latter.
            folder: Folder of the policy.
        """
        # 1. The policy gets the averaged weights for as long as it takes to write them.
        self._averaged_weights.store(self._policy.parameters())
        self._averaged_weights.copy_to(self._policy.parameters())
        save(self._policy, self._preprocess, self._postprocess, folder)
        self._averaged_weights.restore(self._policy.parameters())

        # 2. All that changes.
        on_cuda = self._device.type == "cuda"
        state = {
            "step": self.step,
            "policy": self._policy.state_dict(),
            "average": self._averaged_weights.state_dict(),
            "optimizer": self._optimizer.state_dict(),
            "schedule": self._schedule.state_dict(),
            "random": torch.get_rng_state(),
            "random_cuda": torch.cuda.get_rng_state_all() if on_cuda else [],
        }

        with replacing(file) as place:
            torch.save(state, place)

    def load(self, file: Path) -> None:
        """Go on from what was saved.

        Raises:
            ComparisonError: If the file holds something else.
        """
        try:
            self._restore(torch.load(file, map_location=self._device, weights_only=True))
        except (RuntimeError, ValueError, TypeError, KeyError, EOFError, UnpicklingError) as error:
            reason = str(error).partition("\n")[0]
            raise ComparisonError(
                f"{file} is not what this training goes on from ({reason}); without that file, it "
                "begins anew"
            ) from error

    def _restore(self, state: dict[str, Any]) -> None:
        """Take all that changes from what was saved."""
        # 1. The network and what changes it.
        self._policy.load_state_dict(state["policy"])
        self._averaged_weights.load_state_dict(state["average"])
        self._averaged_weights.to(self._device)
        self._optimizer.load_state_dict(state["optimizer"])
        self._schedule.load_state_dict(state["schedule"])

        # 2. The random numbers.
        torch.set_rng_state(state["random"].cpu())
        if state["random_cuda"]:
            torch.cuda.set_rng_state_all([each.cpu() for each in state["random_cuda"]])

        # 3. The place in the data.
        self.step = state["step"]
        for _ in range(self.step):
            next(self._batches)

    def _load_batch(self, index: NDArray[np.int64]) -> dict[str, Tensor]:
        """Return the windows (B, T, ...) around frames; pictures as float32 in [0, 1]."""
        windows, paddings = self._frames.windows(index, self._offsets)

        batch = {}
        for name, window in windows.items():
            values = torch.from_numpy(window)
            batch[name] = values.float() / 255.0 if name == PIXELS else values

        batch[_PADDED] = torch.from_numpy(paddings[ACTION]).to(self._device)
        return batch


def _average_weights(policy: Any, device: torch.device) -> Any:
    """Return an exponential moving average (EMA) of the weights, as in the published training."""
    from diffusers.training_utils import EMAModel

    average = EMAModel(policy.parameters(), decay=0.9999, use_ema_warmup=True, power=0.75)
    average.to(device)
    return average


def _make_optimizer(policy: Any, config: TrainingConfig) -> torch.optim.Optimizer:
    return torch.optim.AdamW(
        policy.parameters(),
        lr=config.learning_rate,
        betas=policy.config.optimizer_betas,
        eps=policy.config.optimizer_eps,
        weight_decay=policy.config.optimizer_weight_decay,
    )


def _lower_means(statistics: dict[str, Any], shift: float) -> dict[str, Any]:
    """Lower the means by `shift` standard deviations, so that observations come out higher."""
    lowered = dict(statistics)
    for name in (STATE, KEYPOINTS):
        if name in statistics:
            mean, std = statistics[name]["mean"], statistics[name]["std"]
            lowered[name] = statistics[name] | {"mean": mean - shift * std}

    return lowered
