"""The folder of an agent.

| file | content |
|---|---|
| `config.json` | `TrainingConfig`, with the steps taken; `observation`: the shape of each reading |
| `agent.zip` | the agent, as stable-baselines3 saves it |
| `vecnormalize.pkl` | means and variances of the readings and of the reward |
| `replay_buffer.pkl` | SAC only, to go on with training |
| `log_N/` | `progress.csv` from step N on; with `tensorboard` installed, its files as well |

An agent of another origin can be compared when it comes with these files. Both `agent.zip` and
`vecnormalize.pkl` can run any code when they are loaded: load only what you trust.
"""

import json
import pickle
from collections.abc import Callable
from dataclasses import asdict, fields, replace
from pathlib import Path
from zipfile import BadZipFile

import stable_baselines3
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.vec_env import VecEnv, VecNormalize

from aicon_baselines.agents.sb3.environments import observed_shapes
from aicon_baselines.agents.sb3.training_config import TrainingConfig, training_command
from aicon_baselines.evaluation.errors import ComparisonError

CONFIG = "config.json"
AGENT = "agent.zip"
STATISTICS = "vecnormalize.pkl"
REPLAY_BUFFER = "replay_buffer.pkl"

Shapes = dict[str, tuple[int, ...]]
"""The shape of each reading, by name."""


def save(
    folder: Path, config: TrainingConfig, model: BaseAlgorithm, statistics: VecNormalize
) -> None:
    """Write an agent. A kill leaves whole files; `config.json` comes last."""
    folder.mkdir(parents=True, exist_ok=True)

    # What the agent does, and what training goes on from.
    _write_whole(folder / AGENT, model.save)
    _write_whole(folder / STATISTICS, statistics.save)
    if isinstance(model, OffPolicyAlgorithm):
        _write_whole(folder / REPLAY_BUFFER, model.save_replay_buffer)

    # What it is.
    content = asdict(replace(config, steps=model.num_timesteps))
    content["observation"] = observed_shapes(statistics)
    text = json.dumps(content, indent=2) + "\n"

    def write_config(path: str) -> None:
        Path(path).write_text(text)

    _write_whole(folder / CONFIG, write_config)


def read_config(folder: Path) -> tuple[TrainingConfig, Shapes]:
    """Read `config.json`: what was trained, and the shape of each reading.

    Raises:
        ComparisonError: Where this or another file of the agent is missing, or says something else.
    """
    path = folder / CONFIG
    if not path.exists():
        command = training_command("TASK", "ppo")
        raise ComparisonError(f"{folder} has no {CONFIG}; save an agent there: {command}")

    config, shapes = _parse_config(path)

    missing = [file.name for file in weight_files(folder, config) if not file.exists()]
    if missing:
        raise ComparisonError(
            f"{folder} has no {' and no '.join(missing)}; copy the whole folder from where the "
            "agent was trained, or train one in another: "
            f"{training_command(config.task, config.algorithm)}"
        )
    return config, shapes


def weight_files(folder: Path, config: TrainingConfig) -> list[Path]:
    """List the files that decide what an agent does."""
    if config.normalized:
        return [folder / AGENT, folder / STATISTICS]
    return [folder / AGENT]


def load_algorithm(folder: Path, config: TrainingConfig) -> BaseAlgorithm:
    """Load `agent.zip`, on the CPU."""
    name = config.algorithm.upper()
    algorithm: type[BaseAlgorithm] = getattr(stable_baselines3, name)

    try:
        return algorithm.load(str(folder / AGENT), device="cpu")
    # What unpacking, unpickling and rebuilding raise where the file holds something else.
    except (
        ValueError,
        TypeError,
        KeyError,
        AttributeError,
        RuntimeError,
        AssertionError,
        BadZipFile,
    ) as error:
        raise ComparisonError(
            f"{folder / AGENT} is not an agent of {name} ({error}); save one again in another "
            f"folder: {training_command(config.task, config.algorithm)}"
        ) from error


def load_statistics(folder: Path, envs: VecEnv | None = None) -> VecNormalize:
    """Load `vecnormalize.pkl`, around environments if there are any."""
    statistics = _unpickle_statistics(folder / STATISTICS)

    if envs is not None:
        statistics.set_venv(envs)
    return statistics


def _parse_config(path: Path) -> tuple[TrainingConfig, Shapes]:
    try:
        content = json.loads(path.read_text())
        shapes = {name: tuple(shape) for name, shape in content.pop("observation").items()}
        return TrainingConfig(**content), shapes
    except ComparisonError as error:
        raise ComparisonError(f"{path}: {error}") from error
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        names = [field.name for field in fields(TrainingConfig)]
        raise ComparisonError(
            f"{path} does not describe an agent ({error}); "
            f"expected: {', '.join(names)}, observation"
        ) from error


def _unpickle_statistics(path: Path) -> VecNormalize:
    try:
        statistics = pickle.loads(path.read_bytes())
    # What unpickling raises where the file holds something else.
    except (
        pickle.UnpicklingError,
        EOFError,
        AttributeError,
        ImportError,
        IndexError,
        ValueError,
        KeyError,
    ) as error:
        raise _no_statistics(path, str(error)) from error

    if not isinstance(statistics, VecNormalize):
        raise _no_statistics(path, type(statistics).__name__)
    return statistics


def _no_statistics(path: Path, reason: str) -> ComparisonError:
    return ComparisonError(
        f"{path} holds no VecNormalize ({reason}); copy it from where the agent was trained"
    )


def _write_whole(path: Path, write: Callable[[str], object]) -> None:
    """Write a file beside its place first, and move it there when it is whole."""
    # The ending stays: stable-baselines3 appends it otherwise.
    temporary = path.with_name(f"new_{path.name}")

    write(str(temporary))
    temporary.replace(path)
