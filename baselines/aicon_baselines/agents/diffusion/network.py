"""LeRobot's configuration of the network that is trained."""

from collections.abc import Sequence
from typing import Any

from aicon_baselines.agents.diffusion.features import PIXELS, TYPES
from aicon_baselines.agents.diffusion.installed import import_lerobot
from aicon_baselines.agents.diffusion.settings import Training


def make_config(config: Training, features: dict[str, dict[str, Any]], device: str = "cpu") -> Any:
    """Return LeRobot's configuration of the policy; all is set, because its defaults differ between versions."""
    types = import_lerobot("configs.types")
    known = {name: _describe(name, features[name]["shape"], types) for name in features}
    modes = types.NormalizationMode
    return import_lerobot("policies.diffusion.configuration_diffusion").DiffusionConfig(
        input_features={name: feature for name, feature in known.items() if name != "action"},
        output_features={"action": known["action"]},
        # ENV is missing in LeRobot's default: keypoints would come in px.
        normalization_mapping={
            "VISUAL": modes.MEAN_STD,
            "STATE": modes[config.normalization],
            "ENV": modes[config.normalization],
            "ACTION": modes.MIN_MAX,
        },
        device=device,
        push_to_hub=False,
        n_obs_steps=2,
        horizon=config.horizon,
        n_action_steps=config.action_steps,
        # Windows may begin near an episode's end, whose success is what matters most; what lies beyond is no action.
        drop_n_last_frames=0,
        do_mask_loss_for_padding=True,
        crop_shape=(config.crop, config.crop) if config.observation == "pixels" else None,
        crop_is_random=True,
        vision_backbone="resnet18",
        pretrained_backbone_weights=None,
        use_group_norm=True,
        use_separate_rgb_encoder_per_camera=False,
        spatial_softmax_num_keypoints=32,
        down_dims=config.down_dims,
        kernel_size=config.kernel,
        n_groups=8,
        diffusion_step_embed_dim=128,
        use_film_scale_modulation=True,
        noise_scheduler_type="DDPM",
        num_train_timesteps=100,
        beta_schedule="squaredcos_cap_v2",
        beta_start=0.0001,
        beta_end=0.02,
        prediction_type=config.prediction,
        clip_sample=True,
        clip_sample_range=1.0,
        optimizer_lr=config.learning_rate,
        optimizer_betas=(0.95, 0.999),
        optimizer_eps=1e-8,
        optimizer_weight_decay=1e-6,
        scheduler_name="cosine",
        scheduler_warmup_steps=config.warmup,
    )


def _describe(name: str, shape: Sequence[int], types: Any) -> Any:
    """Describe a feature of a dataset as one of a policy, which takes pictures with channels first."""
    if name == PIXELS:
        shape = (shape[2], *shape[:2])
    return types.PolicyFeature(type=types.FeatureType[TYPES[name]], shape=tuple(shape))
