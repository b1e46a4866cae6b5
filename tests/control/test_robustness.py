"""No readings, however far from the plausible, make a bad action."""

import numpy as np
import pytest
import torch
from _inputs import DTYPES
from hypothesis import given, settings
from hypothesis import strategies as st

from aicon_torch import make_policy
from aicon_torch.models import presets

EXTREME = st.floats(allow_nan=False, allow_infinity=False, width=32) | st.sampled_from(
    [0.0, -0.0, 1e-300, 1e-30, 0.13, 0.2, 1.0, 20.0, 1e6, 1e30, 3e38, -3e38, np.pi, -np.pi, 4.0]
)


@pytest.mark.parametrize("preset", presets("nav2d"))
@pytest.mark.parametrize("dtype", DTYPES, ids=str)
@settings(max_examples=8)
@given(st.lists(st.tuples(EXTREME, EXTREME), min_size=1, max_size=8))
def test_no_finite_readings_make_a_bad_action(
    preset: str, dtype: torch.dtype, recorded: list[tuple[float, float]]
) -> None:
    policy = make_policy("nav2d", preset=preset, dtype=dtype, max_speed=0.3)
    memory = None

    for bearing, clearance in recorded:
        action, memory = policy.predict(
            {"bearing": np.array([bearing]), "range": np.array([clearance])}, memory
        )
        assert np.isfinite(action).all()
        assert np.linalg.norm(action) <= 0.3 * (1 + 1e-6)
        assert (np.abs(action) <= np.float32(0.3)).all()
        assert all(value.isfinite().all() for value in memory.values() if value.is_floating_point())


@pytest.mark.parametrize("dtype", DTYPES, ids=str)
@settings(max_examples=10)
@given(
    st.lists(st.tuples(st.floats(-np.pi, np.pi), st.floats(0.0, 20.0)), min_size=10, max_size=20)
)
def test_no_plausible_readings_make_a_bad_action(
    dtype: torch.dtype, recorded: list[tuple[float, float]]
) -> None:
    for preset in ("aicon", "paper_literal"):
        policy = make_policy("nav2d", preset=preset, dtype=dtype)
        memory = None
        for bearing, clearance in recorded:
            action, memory = policy.predict(
                {"bearing": np.array([bearing]), "range": np.array([clearance])}, memory
            )
            assert np.isfinite(action).all() and np.linalg.norm(action) <= 0.5 * (1 + 1e-6)
