"""Means and variances of readings and return, as a file of numbers: reading it runs no code."""

from pathlib import Path
from typing import Any, cast

import numpy as np
from stable_baselines3.common.running_mean_std import RunningMeanStd
from stable_baselines3.common.vec_env import VecEnv, VecNormalize

from aicon_baselines.agents.sb3.environments import normalize
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.files import read_json, write_json


def save_statistics(path: Path, normalized: VecNormalize) -> None:
    """Write the statistics of environments."""
    readings = cast("dict[str, RunningMeanStd]", normalized.obs_rms)
    write_json(
        path,
        {
            "readings": {name: _to_numbers(moments) for name, moments in readings.items()},
            "return": _to_numbers(normalized.ret_rms),
        },
    )


def load_statistics(path: Path, envs: VecEnv, discount: float) -> VecNormalize:
    """Normalise environments by saved statistics.

    Args:
        path: The file.
        envs: The environments.
        discount: Discount factor of the return.

    Raises:
        ComparisonError: If the file holds something else, or statistics of other readings.
    """
    content = read_json(path)
    normalized = normalize(envs, discount)
    readings = cast("dict[str, RunningMeanStd]", normalized.obs_rms)

    try:
        _check_names(content["readings"], readings)
        for name, moments in readings.items():
            _set(moments, content["readings"][name])
        _set(normalized.ret_rms, content["return"])
    except (KeyError, TypeError, ValueError) as error:
        raise ComparisonError(
            f"{path} holds no statistics of this agent ({error}); copy it from where the agent "
            "was trained"
        ) from error
    return normalized


def _to_numbers(moments: RunningMeanStd) -> dict[str, Any]:
    mean, variance = np.asarray(moments.mean), np.asarray(moments.var)
    return {"mean": mean.tolist(), "var": variance.tolist(), "count": float(moments.count)}


def _check_names(saved: dict[str, Any], readings: dict[str, RunningMeanStd]) -> None:
    if set(saved) != set(readings):
        raise ValueError(f"of {', '.join(sorted(saved))}, expected {', '.join(sorted(readings))}")


def _set(moments: RunningMeanStd, saved: dict[str, Any]) -> None:
    """Replace moments by saved ones of the same shape."""
    mean, variance = np.array(saved["mean"], np.float64), np.array(saved["var"], np.float64)
    shape = np.shape(moments.mean)
    if not mean.shape == variance.shape == shape:
        raise ValueError(f"shape {mean.shape}, expected {shape}")

    count = float(saved["count"])
    if not (np.isfinite(mean).all() and np.isfinite(variance).all() and np.isfinite(count)):
        raise ValueError("a number that is not finite")
    if (variance < 0.0).any() or count <= 0.0:
        raise ValueError(f"variances {variance.tolist()} of {count} values")
    moments.mean, moments.var, moments.count = mean, variance, count
