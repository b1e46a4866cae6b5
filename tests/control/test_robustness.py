"""No readings, however far from the plausible, make a bad action."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import torch
from _inputs import DTYPES, lean
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from torch import Tensor

from aicon_torch import Policy
from aicon_torch.models import presets

Readings = list[tuple[float, float]]
"""Bearing, rad, and clearance, m, of each step."""

EXTREME = st.floats(allow_nan=False, allow_infinity=False, width=32) | st.sampled_from(
    [0.0, -0.0, 1e-300, 1e-30, 0.13, 0.2, 1.0, 20.0, 1e6, 1e30, 3e38, -3e38, np.pi, -np.pi, 4.0]
)
PLAUSIBLE = st.tuples(st.floats(-np.pi, np.pi), st.floats(0.0, 20.0))

every_precision = pytest.mark.parametrize("dtype", DTYPES, ids=str)


def steps(policy: Policy, recorded: Readings) -> Iterator[tuple[NDArray[Any], dict[str, Tensor]]]:
    """Action and memory of each step."""
    memory = None

    for bearing, clearance in recorded:
        reading = {"bearing": np.array([bearing]), "range": np.array([clearance])}
        action, memory = policy.predict(reading, memory)
        yield action, memory


@pytest.mark.parametrize("preset", presets("nav2d"))
@every_precision
@given(recorded=st.lists(st.tuples(EXTREME, EXTREME), min_size=1, max_size=8))
def test_no_finite_readings_make_a_bad_action(
    preset: str, dtype: torch.dtype, recorded: Readings
) -> None:
    policy = lean("nav2d", preset=preset, dtype=dtype, max_speed=0.3)

    for action, memory in steps(policy, recorded):
        assert np.isfinite(action).all()
        assert np.linalg.norm(action) <= 0.3 * (1 + 1e-6)
        assert (np.abs(action) <= np.float32(0.3)).all()
        assert all(value.isfinite().all() for value in memory.values() if value.is_floating_point())


@pytest.mark.parametrize("preset", ["aicon", "paper_literal"])
@every_precision
@given(recorded=st.lists(PLAUSIBLE, min_size=6, max_size=12))
def test_no_plausible_readings_make_a_bad_action(
    preset: str, dtype: torch.dtype, recorded: Readings
) -> None:
    policy = lean("nav2d", preset=preset, dtype=dtype)

    for action, _ in steps(policy, recorded):
        assert np.isfinite(action).all()
        assert np.linalg.norm(action) <= 0.5 * (1 + 1e-6)
