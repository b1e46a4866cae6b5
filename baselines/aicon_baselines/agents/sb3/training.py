"""Training an agent, and going on with it."""

from collections.abc import Callable
from dataclasses import fields, replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import configure as configure_logger
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.vec_env import VecNormalize
from tqdm import tqdm

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.agents.sb3.environments import make_training_env, normalize
from aicon_baselines.agents.sb3.files import CONFIG, REPLAY, load_algorithm, load_statistics, read_settings, save
from aicon_baselines.agents.sb3.networks import make_algorithm
from aicon_baselines.agents.sb3.settings import Settings


def train(
    config: Settings, folder: Path, checkpoint: int = 50_000, report: Callable[[str], None] = lambda line: None
) -> Settings:
    """Train an agent, or go on with the one in the folder, and save it every `checkpoint` steps and at the end.

    What is learned after a stop differs from what would have been learned without one: episodes begin anew, with other
    seeds, and SAC and PPO draw other numbers.

    Args:
        config: What to train. An agent in the folder must have the same settings, except for the steps.
        folder: Folder of the agent.
        checkpoint: Steps between two saves.
        report: Called with a line of text after each save.

    Returns:
        The settings with the number of steps taken, at least those asked for.
    """
    if checkpoint < 1:
        raise ComparisonError(f"checkpoint must be 1 or more, not {checkpoint}")
    model, statistics = _resume(config, folder) if (folder / CONFIG).exists() else _begin(config)
    missing = config.steps - model.num_timesteps
    if missing > 0:
        formats = ["csv", "tensorboard"] if find_spec("tensorboard") else ["csv"]
        model.set_logger(configure_logger(str(folder / f"log_{model.num_timesteps}"), formats))
        saving = _Saving(config.steps, checkpoint, lambda: save(folder, config, model, statistics), report)
        model.learn(missing, callback=saving, reset_num_timesteps=model.num_timesteps == 0)
        model.logger.close()
    statistics.close()
    return replace(config, steps=model.num_timesteps)


def _begin(config: Settings) -> tuple[BaseAlgorithm, VecNormalize]:
    statistics = normalize(make_training_env(config, config.seed), config.discount)
    return make_algorithm(config, statistics), statistics


def _resume(config: Settings, folder: Path) -> tuple[BaseAlgorithm, VecNormalize]:
    there, _ = read_settings(folder)
    differing = [
        f"{field.name} is {getattr(there, field.name)} there and {getattr(config, field.name)} here"
        for field in fields(config)
        if field.name != "steps" and getattr(there, field.name) != getattr(config, field.name)
    ]
    if differing:
        raise ComparisonError(f"{folder} holds another agent: {'; '.join(differing)}. Choose another folder.")
    model = load_algorithm(folder, there)
    # Other episodes than those since the start; the steps so far, because they are more than the environments.
    statistics = load_statistics(folder, make_training_env(config, config.seed + model.num_timesteps))
    model.set_env(statistics)
    if isinstance(model, OffPolicyAlgorithm) and (folder / REPLAY).exists():
        model.load_replay_buffer(str(folder / REPLAY))
    return model, statistics


class _Saving(BaseCallback):
    """Saves every so many steps and at the end, and shows a bar, on a terminal only."""

    def __init__(self, total: int, interval: int, save: Callable[[], None], report: Callable[[str], None]) -> None:
        super().__init__()
        self._total, self._interval, self._save, self._report = total, interval, save, report

    def _on_training_start(self) -> None:
        self._saved = self.model.num_timesteps
        self._bar = tqdm(initial=self._saved, total=self._total, unit=" steps", smoothing=0.05, disable=None)

    def _on_step(self) -> bool:
        self._bar.update(self.num_timesteps - self._bar.n if not self._bar.disable else 0)
        if self.num_timesteps - self._saved >= self._interval:
            self._saved = self.num_timesteps
            self._save()
            self._bar.clear()
            self._report(f"{self.num_timesteps:,} steps: {self._recent()}")
        return True

    def _on_training_end(self) -> None:
        self._bar.close()
        self._save()

    def _recent(self) -> str:
        """Tell how the last 100 training episodes went."""
        rewards = [episode["r"] for episode in self.model.ep_info_buffer or ()]
        successes = list(self.model.ep_success_buffer or ())
        if not rewards or not successes:
            return "no episode has ended yet"
        return f"success {100.0 * np.mean(successes):.0f} %, reward {np.mean(rewards):.2f} (with exploration)"
