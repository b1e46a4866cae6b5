"""Loading the network of an agent: its numbers alone, or all of it where its origin is trusted.

`agent.zip` holds numbers and a description of the agent, and reading the description can run any
code. So the agent is built as the training builds it, and only the numbers are read. An agent of
another origin may have another network; it is loaded with its description where the user says so.
"""

import pickle
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from pickle import UnpicklingError
from typing import Any
from zipfile import BadZipFile

import stable_baselines3
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.save_util import load_from_zip_file
from stable_baselines3.common.vec_env import VecEnv, VecNormalize

from aicon_baselines.agents.sb3.algorithms import make_algorithm
from aicon_baselines.agents.sb3.training_config import (
    ALGORITHMS,
    TrainingConfig,
    training_command,
)
from aicon_baselines.evaluation.errors import ComparisonError

# What reading and rebuilding raise where a file holds something else.
_NOT_AN_AGENT = (
    ValueError,
    TypeError,
    KeyError,
    AttributeError,
    IndexError,
    RuntimeError,
    AssertionError,
    ImportError,
    EOFError,
    UnpicklingError,
    BadZipFile,
)


def load_algorithm(path: Path, config: TrainingConfig, envs: VecEnv) -> BaseAlgorithm:
    """Build what the training builds, on the CPU, with the saved numbers; no code of the file runs.

    Args:
        path: An `agent.zip`.
        config: What was trained.
        envs: The environments, normalised as in training.

    Raises:
        ComparisonError: If the file holds something else, or an agent with another network.
    """
    if config.algorithm not in ALGORITHMS:
        raise ComparisonError(
            f"{path} is an agent of {config.algorithm.upper()}, which is not trained here. "
            f"{needs_trust(path)}"
        )

    model: Any = make_algorithm(config, envs)
    with _agent_expected(path, config, f"or it has another network. {needs_trust(path)}"):
        # Tensors only: stable-baselines3 reads them with torch's `weights_only`.
        _, weights, variables = load_from_zip_file(path, load_data=False, device="cpu")
        if set(weights) != set(model.get_parameters()):
            raise ValueError(f"it holds {', '.join(sorted(weights)) or 'no tensors'}")
        model.set_parameters(weights, device="cpu")

        # The temperature of SAC is a single tensor beside the networks.
        if config.algorithm == "sac":
            model.log_ent_coef.data = (variables or {})["log_ent_coef"].data

    algorithm: BaseAlgorithm = model
    return algorithm


def load_network(path: Path, config: TrainingConfig, envs: VecEnv) -> BaseAlgorithm:
    """Do the same for an agent that only acts: it gets no room to remember what it sees."""
    return load_algorithm(path, replace(config, envs=1, rollout=2, steps=1), envs)


def load_trusted_algorithm(path: Path, config: TrainingConfig) -> BaseAlgorithm:
    """Load an agent as stable-baselines3 does, which can run any code that the file holds."""
    algorithm: type[BaseAlgorithm] = getattr(stable_baselines3, config.algorithm.upper())
    with _agent_expected(path, config, "save one again in another folder"):
        return algorithm.load(str(path), device="cpu")


def load_trusted_statistics(path: Path) -> VecNormalize:
    """Load a pickled `VecNormalize`, which can run any code that the file holds."""
    try:
        statistics = pickle.loads(path.read_bytes())
    except _NOT_AN_AGENT as error:
        raise _no_statistics(path, str(error)) from error

    if not isinstance(statistics, VecNormalize):
        raise _no_statistics(path, type(statistics).__name__)
    return statistics


def needs_trust(path: Path) -> str:
    """Say how to load a file that can run code."""
    return (
        f"Loading all of {path.name} can run any code that is in it: if you trust where it comes "
        "from, compare it with --trust"
    )


def _no_statistics(path: Path, reason: str) -> ComparisonError:
    return ComparisonError(
        f"{path} holds no VecNormalize ({reason}); copy it from where the agent was trained"
    )


@contextmanager
def _agent_expected(path: Path, config: TrainingConfig, remedy: str) -> Iterator[None]:
    """Say what a file should hold where it holds something else."""
    try:
        yield
    except _NOT_AN_AGENT as error:
        reason = str(error).partition("\n")[0]
        raise ComparisonError(
            f"{path} is not an agent of {config.algorithm.upper()} ({reason}), {remedy}; "
            f"to train one: {training_command(config.task, config.algorithm)}"
        ) from error
