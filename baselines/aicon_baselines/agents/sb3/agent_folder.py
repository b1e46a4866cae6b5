"""The folder of an agent.

| file | content |
|---|---|
| `config.json` | `TrainingConfig`, with the steps taken; `observation`: the shape of each reading |
| `agent.zip` | the agent, as stable-baselines3 saves it |
| `statistics.json` | means and variances of the readings and of the return |
| `replay_buffer.npz` | SAC only, to go on with training |
| `log_N/` | `progress.csv` from step N on; with `tensorboard` installed, its files as well |

No file runs code when it is read: of `agent.zip` only the numbers are. An agent of another origin
can be compared when it comes with the first two files and, if its readings were normalised, with
stable-baselines3's `vecnormalize.pkl`; loading it may run code and needs `trust`.
"""

from contextlib import ExitStack
from dataclasses import asdict, fields, replace
from pathlib import Path

from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.vec_env import VecNormalize

from aicon_baselines.agents.sb3.environments import make_training_envs, observed_shapes
from aicon_baselines.agents.sb3.replay_file import save_replay_buffer
from aicon_baselines.agents.sb3.statistics import load_statistics, save_statistics
from aicon_baselines.agents.sb3.training_config import TrainingConfig, training_command
from aicon_baselines.agents.sb3.weights import (
    load_network,
    load_trusted_algorithm,
    load_trusted_statistics,
    needs_trust,
)
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.files import read_json, replacing, write_json

CONFIG = "config.json"
AGENT = "agent.zip"
STATISTICS = "statistics.json"
REPLAY_BUFFER = "replay_buffer.npz"

_PICKLED_STATISTICS = "vecnormalize.pkl"

Shapes = dict[str, tuple[int, ...]]
"""The shape of each reading, by name."""


def save(
    folder: Path, config: TrainingConfig, model: BaseAlgorithm, statistics: VecNormalize
) -> None:
    """Write an agent: a kill before the last of its files is written leaves the agent of before."""
    folder.mkdir(parents=True, exist_ok=True)

    # They take their places at the end, the last one first: the steps that `config.json` counts are
    # those of the weights.
    with ExitStack() as stack:

        def place(name: str) -> Path:
            return stack.enter_context(replacing(folder / name))

        # What it is ...
        content = asdict(replace(config, steps=model.num_timesteps))
        content["observation"] = observed_shapes(statistics)
        write_json(place(CONFIG), content)

        # ... what it does, and what training goes on from.
        model.save(place(AGENT))
        save_statistics(place(STATISTICS), statistics)
        if isinstance(model, OffPolicyAlgorithm):
            save_replay_buffer(place(REPLAY_BUFFER), model)


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
    if not config.normalized:
        return [folder / AGENT]

    pickled = folder / _PICKLED_STATISTICS
    statistics = folder / STATISTICS
    is_foreign = pickled.exists() and not statistics.exists()
    return [folder / AGENT, pickled if is_foreign else statistics]


def load_agent(
    folder: Path, config: TrainingConfig, trust: bool = False
) -> tuple[BaseAlgorithm, VecNormalize | None]:
    """Load an agent that acts, and what normalises its readings.

    Args:
        folder: Its folder.
        config: What `config.json` says.
        trust: Whether code that its files may hold is allowed to run.

    Raises:
        ComparisonError: If a file holds something else, or more than numbers without `trust`.
    """
    *_, last = weight_files(folder, config)
    is_pickled = last.name == _PICKLED_STATISTICS
    if is_pickled and not trust:
        raise ComparisonError(f"{folder} has no {STATISTICS}. {needs_trust(last)}")

    # One environment, for the shapes of readings and actions.
    envs = make_training_envs(replace(config, envs=1), config.seed)
    if is_pickled:
        normalized = load_trusted_statistics(last)
    elif config.normalized:
        normalized = load_statistics(last, envs, config.discount)
    else:
        normalized = None

    if trust:
        return load_trusted_algorithm(folder / AGENT, config), normalized
    return load_network(folder / AGENT, config, normalized or envs), normalized


def _parse_config(path: Path) -> tuple[TrainingConfig, Shapes]:
    content = read_json(path)
    try:
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
