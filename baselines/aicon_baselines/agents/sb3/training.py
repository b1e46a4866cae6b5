"""Training an agent, and going on with it."""

import sys
from collections.abc import Callable
from contextlib import closing
from dataclasses import asdict, replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback, EveryNTimesteps
from stable_baselines3.common.logger import configure as configure_logger
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.vec_env import VecNormalize

from aicon_baselines.agents.sb3.agent_folder import (
    AGENT,
    CONFIG,
    REPLAY_BUFFER,
    STATISTICS,
    read_config,
    save,
)
from aicon_baselines.agents.sb3.algorithms import make_algorithm
from aicon_baselines.agents.sb3.environments import make_training_envs, normalize
from aicon_baselines.agents.sb3.replay_file import load_replay_buffer
from aicon_baselines.agents.sb3.statistics import load_statistics
from aicon_baselines.agents.sb3.training_config import TrainingConfig
from aicon_baselines.agents.sb3.weights import load_algorithm
from aicon_baselines.evaluation.errors import check_counts
from aicon_baselines.files import check_same_config, only_writer


def train(
    config: TrainingConfig,
    folder: Path,
    checkpoint: int = 50_000,
    report: Callable[[str], None] | None = None,
) -> TrainingConfig:
    """Train an agent, or go on with the one in the folder; saved now and then, and at the end.

    What is learned after a stop differs from what would have been learned without one: episodes
    begin anew, with other seeds, and SAC and PPO draw other numbers.

    Args:
        config: What to train. An agent in the folder must have the same, except for the steps.
        folder: Folder of the agent.
        checkpoint: Steps between two saves.
        report: Called with a line of text after each save.

    Returns:
        The configuration with the number of steps taken, at least those asked for.

    Raises:
        ComparisonError: Where the folder holds another agent, or another process trains there.
    """
    check_counts(checkpoint=checkpoint)
    with only_writer(folder):
        # 1. What is trained, and the environments that it is trained in.
        resumes = (folder / CONFIG).exists()
        model, statistics = _resume(config, folder) if resumes else _begin(config)

        # 2. What is missing.
        missing_steps = config.steps - model.num_timesteps
        if missing_steps > 0:
            _learn(model, missing_steps, statistics, config, folder, checkpoint, report)

    statistics.close()
    return replace(config, steps=model.num_timesteps)


def _begin(config: TrainingConfig) -> tuple[BaseAlgorithm, VecNormalize]:
    envs = make_training_envs(config, config.seed)
    statistics = normalize(envs, config.discount)
    return make_algorithm(config, statistics), statistics


def _resume(config: TrainingConfig, folder: Path) -> tuple[BaseAlgorithm, VecNormalize]:
    saved, _ = read_config(folder)
    wanted = replace(config, steps=saved.steps)
    check_same_config(folder, "another agent", asdict(saved), asdict(wanted))

    # Other episodes than at the start: there have been at least as many steps as environments, so
    # that none gets a seed that another began with.
    envs = make_training_envs(config, config.seed + saved.steps)
    statistics = load_statistics(folder / STATISTICS, envs, config.discount)
    model = load_algorithm(folder / AGENT, config, statistics)
    model.num_timesteps = saved.steps

    if isinstance(model, OffPolicyAlgorithm) and (folder / REPLAY_BUFFER).exists():
        load_replay_buffer(folder / REPLAY_BUFFER, model)
    return model, statistics


def _learn(
    model: BaseAlgorithm,
    steps: int,
    statistics: VecNormalize,
    config: TrainingConfig,
    folder: Path,
    checkpoint: int,
    report: Callable[[str], None] | None,
) -> None:
    """Train for so many steps more."""

    def save_agent() -> None:
        save(folder, config, model, statistics)

    log_folder = folder / f"log_{model.num_timesteps}"
    log_formats = ["csv", "tensorboard"] if find_spec("tensorboard") else ["csv"]
    model.set_logger(configure_logger(str(log_folder), log_formats))

    # Now and then, and at the end.
    checkpoints = EveryNTimesteps(checkpoint, _Checkpoint(save_agent, report))
    checkpoints.last_time_trigger = model.num_timesteps
    with closing(model.logger):
        model.learn(
            steps,
            callback=checkpoints,
            reset_num_timesteps=model.num_timesteps == 0,
            progress_bar=sys.stderr.isatty() and find_spec("rich") is not None,
        )
        save_agent()


class _Checkpoint(BaseCallback):
    """Saves, and reports how the last 100 training episodes went."""

    def __init__(self, save: Callable[[], None], report: Callable[[str], None] | None) -> None:
        super().__init__()
        self._save, self._report = save, report

    def _on_step(self) -> bool:
        self._save()
        if self._report is not None:
            self._report(f"{self.num_timesteps:,} steps: {self._summary()}")
        return True

    def _summary(self) -> str:
        rewards = [episode["r"] for episode in self.model.ep_info_buffer or ()]
        successes = list(self.model.ep_success_buffer or ())
        if not rewards or not successes:
            return "no episode has ended yet"

        success_rate = 100.0 * np.mean(successes)
        return f"success {success_rate:.0f} %, reward {np.mean(rewards):.2f} (with exploration)"
