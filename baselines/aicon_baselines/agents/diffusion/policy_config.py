"""LeRobot's description of the policy that is trained."""

from collections.abc import Mapping, Sequence
from typing import Any

from aicon_baselines.agents.diffusion.feature_names import ACTION, FEATURE_TYPES, PIXELS
from aicon_baselines.agents.diffusion.lerobot_import import import_lerobot
from aicon_baselines.agents.diffusion.training_config import TrainingConfig

# The published pushT policy's; all is named, because LeRobot's defaults differ between versions.
_OBSERVATIONS = {
    "n_obs_steps": 2,
    # Windows may begin near an episode's end, whose success is what matters most; what lies beyond
    # is no action.
    "drop_n_last_frames": 0,
    "do_mask_loss_for_padding": True,
}
_IMAGE_ENCODER = {
    "crop_is_random": True,
    "vision_backbone": "resnet18",
    "pretrained_backbone_weights": None,
    "use_group_norm": True,
    "use_separate_rgb_encoder_per_camera": False,
    "spatial_softmax_num_keypoints": 32,
}
_NETWORK = {
    "n_groups": 8,
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
}
_OPTIMIZER = {
    "optimizer_betas": (0.95, 0.999),
    "optimizer_eps": 1e-8,
    "optimizer_weight_decay": 1e-6,
    "scheduler_name": "cosine",
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
    inputs = {name: _describe(name, features[name]["shape"]) for name in features}
    outputs = {ACTION: inputs.pop(ACTION)}
    crop_shape = (config.crop, config.crop) if config.observation == "pixels" else None

    configuration = import_lerobot("policies.diffusion.configuration_diffusion")
    return configuration.DiffusionConfig(
        input_features=inputs,
        output_features=outputs,
        normalization_mapping=_normalization_modes(config),
        device=device,
        push_to_hub=False,
        horizon=config.horizon,
        n_action_steps=config.action_steps,
        crop_shape=crop_shape,
        down_dims=config.down_dims,
        kernel_size=config.kernel,
        prediction_type=config.prediction,
        optimizer_lr=config.learning_rate,
        scheduler_warmup_steps=config.warmup,
        **_OBSERVATIONS,
        **_IMAGE_ENCODER,
        **_NETWORK,
        **_NOISE,
        **_OPTIMIZER,
    )


def _normalization_modes(config: TrainingConfig) -> dict[str, Any]:
    """Return how each type of feature is normalised."""
    modes = import_lerobot("configs.types").NormalizationMode
    return {
        "VISUAL": modes.MEAN_STD,
        "STATE": modes[config.normalization],
        "ENV": modes[config.normalization],  # missing in LeRobot's default: they would come in px
        "ACTION": modes.MIN_MAX,
    }


def _describe(name: str, shape: Sequence[int]) -> Any:
    """Describe a feature of a dataset as one of a policy, where pictures have channels first."""
    if name == PIXELS:
        height, width, channels = shape
        shape = (channels, height, width)

    types = import_lerobot("configs.types")
    return types.PolicyFeature(type=types.FeatureType[FEATURE_TYPES[name]], shape=tuple(shape))
