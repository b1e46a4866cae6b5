"""What changes during training: network, averaged weights, optimiser and random numbers."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import torch

from aicon_baselines.agents.diffusion.checkpoint import save
from aicon_baselines.agents.diffusion.dataset import Frames
from aicon_baselines.agents.diffusion.features import KEYPOINTS, PIXELS, STATE
from aicon_baselines.agents.diffusion.installed import import_lerobot
from aicon_baselines.agents.diffusion.network import make_config
from aicon_baselines.agents.diffusion.settings import Training


class Learner:
    """Network, averaged weights, optimiser and random numbers: what changes during training."""

    def __init__(self, config: Training, frames: Frames, device: torch.device) -> None:
        from diffusers.optimization import get_scheduler
        from diffusers.training_utils import EMAModel

        self._config, self._frames, self._device = config, frames, device
        torch.manual_seed(config.seed)
        self._policy_config = make_config(config, frames.features, str(device))
        self._policy: Any = import_lerobot("policies.diffusion.modeling_diffusion").DiffusionPolicy(self._policy_config)
        self._policy.to(device).train()
        self._preprocess, self._postprocess = import_lerobot("policies.factory").make_pre_post_processors(
            self._policy_config, dataset_stats=_shifted(frames.statistics, config.shift)
        )
        self._average = EMAModel(self._policy.parameters(), decay=0.9999, use_ema_warmup=True, power=0.75)
        self._average.to(device)
        self._optimizer = torch.optim.AdamW(
            self._policy.parameters(),
            lr=config.learning_rate,
            betas=self._policy_config.optimizer_betas,
            eps=self._policy_config.optimizer_eps,
            weight_decay=self._policy_config.optimizer_weight_decay,
        )
        self._schedule = get_scheduler(
            "cosine", self._optimizer, num_warmup_steps=config.warmup, num_training_steps=config.steps
        )
        self._offsets = {
            name: self._policy_config.action_delta_indices
            if name == "action"
            else self._policy_config.observation_delta_indices
            for name in frames.columns
        }
        self._order = _order(len(frames), config)
        self.step = 0

    @property
    def learning_rate(self) -> float:
        """The learning rate of the next step."""
        return float(self._schedule.get_last_lr()[0])

    def advance(self) -> float:
        """Take one gradient step and return its loss."""
        batch = self._preprocess(self._batch(next(self._order)))
        loss = self._loss(batch)
        loss.backward()  # type: ignore[no-untyped-call]
        torch.nn.utils.clip_grad_norm_(self._policy.parameters(), 10.0)
        self._optimizer.step()
        self._schedule.step()
        self._optimizer.zero_grad()
        self._average.step(self._policy.parameters())
        self.step += 1
        return float(loss.detach())

    def _loss(self, batch: dict[str, torch.Tensor]) -> torch.Tensor:
        """Return the mean squared error of the actions a or the noise ε predicted from √ᾱ a + √(1 - ᾱ) ε.

        Padding does not count.
        """
        model, actions = self._policy.diffusion, batch["action"]
        scheduler = model.noise_scheduler
        levels = scheduler.config.num_train_timesteps
        level = torch.randint(0, levels, (len(actions),), device=self._device)
        noise = torch.randn_like(actions)
        if PIXELS in batch:
            batch["observation.images"] = batch[PIXELS].unsqueeze(2)  # one camera
        condition = model._prepare_global_conditioning(batch)
        predicted = model.unet(scheduler.add_noise(actions, noise, level), level, global_cond=condition)
        target = noise if self._config.prediction == "epsilon" else actions
        error: torch.Tensor = (predicted - target).square() * ~batch["action_is_pad"].unsqueeze(-1)
        return error.mean()

    def _batch(self, index: Any) -> dict[str, torch.Tensor]:
        values, padded = self._frames.windows(index, self._offsets)
        batch = {name: torch.from_numpy(value) for name, value in values.items()}
        batch = {name: value.float() / 255.0 if value.dtype == torch.uint8 else value for name, value in batch.items()}
        return batch | {"action_is_pad": torch.from_numpy(padded["action"]).to(self._device)}

    def save(self, file: Path, folder: Path) -> None:
        """Save what training goes on from in a file, and the policy with averaged weights in a folder."""
        temporary = file.with_name(file.name + ".tmp")
        state = {
            "step": self.step,
            "policy": self._policy.state_dict(),
            "average": self._average.state_dict(),
            "optimizer": self._optimizer.state_dict(),
            "schedule": self._schedule.state_dict(),
            "random": torch.get_rng_state(),
            "random_cuda": torch.cuda.get_rng_state_all() if self._device.type == "cuda" else [],
        }
        torch.save(state, temporary)
        temporary.replace(file)
        self._average.store(self._policy.parameters())
        self._average.copy_to(self._policy.parameters())
        save(self._policy, self._preprocess, self._postprocess, folder)
        self._average.restore(self._policy.parameters())

    def load(self, file: Path) -> None:
        """Go on from what was saved."""
        state = torch.load(file, map_location=self._device, weights_only=True)
        self._policy.load_state_dict(state["policy"])
        self._average.load_state_dict(state["average"])
        self._average.to(self._device)
        self._optimizer.load_state_dict(state["optimizer"])
        self._schedule.load_state_dict(state["schedule"])
        torch.set_rng_state(state["random"].cpu())
        if state["random_cuda"]:
            torch.cuda.set_rng_state_all([each.cpu() for each in state["random_cuda"]])
        self.step = state["step"]
        for _ in range(self.step):
            next(self._order)


def _shifted(statistics: dict[str, Any], shift: float) -> dict[str, Any]:
    """Return statistics with which observations come out higher by so many standard deviations."""
    moved = {
        name: statistics[name] | {"mean": statistics[name]["mean"] - shift * statistics[name]["std"]}
        for name in (STATE, KEYPOINTS)
        if name in statistics
    }
    return statistics | moved


def _order(count: int, config: Training) -> Iterator[Any]:
    """Yield the frames (B,) at which the windows of each step begin; each epoch is a new permutation."""
    rng = np.random.default_rng(config.seed)
    left = np.empty(0, np.int64)
    while True:
        while len(left) < config.batch:
            left = np.concatenate([left, rng.permutation(count)])
        yield left[: config.batch]
        left = left[config.batch :]
