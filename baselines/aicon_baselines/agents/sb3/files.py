"""The folder of an agent.

| file | content |
|---|---|
| `config.json` | `Settings`: what was trained, and for how many steps; `observation`: the shape of each reading |
| `agent.zip` | the agent, as stable-baselines3 saves it |
| `vecnormalize.pkl` | means and variances of the readings and of the reward |
| `replay_buffer.pkl` | SAC only, to go on with training |
| `log_N/` | `progress.csv` from step N on; with the package `tensorboard` installed, its files as well |

An agent of another origin can be compared when it comes with these files. Both `agent.zip` and `vecnormalize.pkl` can
run any code when they are loaded: load only what you trust.
"""

import json
import pickle
from collections.abc import Callable
from dataclasses import asdict, fields, replace
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import stable_baselines3
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.vec_env import VecEnv, VecNormalize

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.agents.sb3.environments import observed_shapes
from aicon_baselines.agents.sb3.settings import Settings, training_command

CONFIG, AGENT, STATISTICS, REPLAY = "config.json", "agent.zip", "vecnormalize.pkl", "replay_buffer.pkl"


def save(folder: Path, config: Settings, model: BaseAlgorithm, statistics: VecNormalize) -> None:
    """Write the agent, each file at once, so that a kill leaves whole ones; `config.json` comes last."""
    folder.mkdir(parents=True, exist_ok=True)
    _write(folder / AGENT, model.save)
    _write(folder / STATISTICS, statistics.save)
    if isinstance(model, OffPolicyAlgorithm):
        _write(folder / REPLAY, model.save_replay_buffer)
    content = asdict(replace(config, steps=model.num_timesteps)) | {"observation": observed_shapes(statistics)}
    _write(folder / CONFIG, lambda path: Path(path).write_text(json.dumps(content, indent=2) + "\n"))


def read_settings(folder: Path) -> tuple[Settings, dict[str, tuple[int, ...]]]:
    """Read `config.json`: the settings, and the shape of each reading; an error says which other file is missing."""
    path = folder / CONFIG
    if not path.exists():
        raise ComparisonError(f"{folder} has no {CONFIG}; save an agent there: {training_command('TASK', 'ppo')}")
    try:
        content = json.loads(path.read_text())
        shapes = {name: tuple(shape) for name, shape in content.pop("observation").items()}
        config = Settings(**content)
    except ComparisonError as error:
        raise ComparisonError(f"{path}: {error}") from error
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        expected = ", ".join(field.name for field in fields(Settings))
        raise ComparisonError(
            f"{path} does not describe an agent ({error}); expected: {expected}, observation"
        ) from error
    missing = [file.name for file in weights(folder, config) if not file.exists()]
    if missing:
        raise ComparisonError(
            f"{folder} has no {' and no '.join(missing)}; copy the whole folder from where the agent was trained, or "
            f"train one in another: {training_command(config.task, config.algorithm)}"
        )
    return config, shapes


def weights(folder: Path, config: Settings) -> list[Path]:
    """List the files that decide what an agent does."""
    return [folder / AGENT, *([folder / STATISTICS] if config.normalized else [])]


def load_algorithm(folder: Path, config: Settings) -> BaseAlgorithm:
    """Load `agent.zip`, on the CPU."""
    kind: type[BaseAlgorithm] = getattr(stable_baselines3, config.algorithm.upper())
    try:
        return kind.load(str(folder / AGENT), device="cpu")
    except (ValueError, TypeError, KeyError, AttributeError, RuntimeError, AssertionError, BadZipFile) as error:
        raise ComparisonError(
            f"{folder / AGENT} is not an agent of {config.algorithm.upper()} ({error}); save one again in another "
            f"folder: {training_command(config.task, config.algorithm)}"
        ) from error


def load_statistics(folder: Path, envs: VecEnv | None = None) -> VecNormalize:
    """Load `vecnormalize.pkl`, around environments if there are any."""
    path = folder / STATISTICS
    try:
        statistics = pickle.loads(path.read_bytes())
        if isinstance(statistics, VecNormalize):
            if envs is not None:
                statistics.set_venv(envs)
            return statistics
        reason = type(statistics).__name__
    except (pickle.UnpicklingError, EOFError, AttributeError, ImportError, IndexError, ValueError, KeyError) as error:
        reason = str(error)
    raise ComparisonError(f"{path} holds no VecNormalize ({reason}); copy it from where the agent was trained")


def _write(path: Path, write: Callable[[str], Any]) -> None:
    temporary = path.with_name(f"new_{path.name}")  # the ending stays: stable-baselines3 appends it otherwise
    write(str(temporary))
    temporary.replace(path)
