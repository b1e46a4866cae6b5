"""Whatever comes in: commands are legal, rows stand alone, and the first good reading heals."""

import os
import shutil
from typing import Any

import numpy as np
import pytest
import torch
from _inputs import drifting, navigation
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from aicon_torch import DirectDescent, ObservationError, Policy

ANYTHING = st.floats(allow_nan=True, allow_infinity=True, width=64) | st.sampled_from(
    [np.nan, np.inf, -np.inf, 5e-324, 1e38, 1e308, -1e308, 0.13, 20.0]
)
MOST = settings.default.max_examples
STEPS = st.lists(st.tuples(ANYTHING, ANYTHING), min_size=1, max_size=6)

PROMPT = Policy(navigation().model, navigation().resolution, DirectDescent())
"""One gradient a step, so that it is compiled in seconds."""

with_compiler = pytest.mark.skipif(
    not shutil.which(os.environ.get("CXX", "g++")), reason="there is no C++ compiler"
)


@pytest.fixture(scope="module")
def compiled() -> Policy:
    return PROMPT.compile()


def check_rows(policy: Policy, hostile: list[tuple[float, float]], kind: Any) -> None:
    """Row 1 of 3 reads anything; the others read what they read without it."""
    good = drifting(len(hostile) + 1, (3,))
    memory = clean = None

    for step, reading in enumerate(good):
        arrays: dict[str, NDArray[Any]] = {key: value.numpy() for key, value in reading.items()}
        bad = {key: value.copy() for key, value in arrays.items()}
        if step < len(hostile):
            bad["bearing"][1], bad["range"][1] = hostile[step]

        action, memory = policy.predict({key: kind(bad[key]) for key in bad}, memory)
        expected, clean = policy.predict({key: kind(arrays[key]) for key in arrays}, clean)
        action, expected = np.asarray(action), np.asarray(expected)

        assert (action[[0, 2]] == expected[[0, 2]]).all()
        assert np.isfinite(action).all()
        assert (np.linalg.norm(action, axis=-1) <= 0.5 * (1 + 1e-6)).all()

    # After a good reading all is finite.
    assert memory is not None
    assert all(value.isfinite().all() for value in memory.values())
    assert memory["z_tar.missed"][1] <= len(hostile)


@pytest.mark.parametrize("kind", [np.asarray, torch.as_tensor])
@settings(max_examples=MOST, deadline=None)
@given(hostile=STEPS)
def test_one_bad_row_touches_no_other(kind: Any, hostile: list[tuple[float, float]]) -> None:
    check_rows(PROMPT, hostile, kind)


@with_compiler
@settings(max_examples=2 * MOST, deadline=None)
@given(hostile=STEPS)
def test_nor_does_it_compiled(compiled: Policy, hostile: list[tuple[float, float]]) -> None:
    check_rows(compiled, hostile, torch.as_tensor)


def test_a_memory_that_is_not_finite_heals_by_row() -> None:
    reading, again = drifting(2, (3,))
    _, memory = PROMPT.predict(reading)
    broken = {key: value.clone() for key, value in memory.items()}
    broken["p_tar"][1] = torch.nan

    action, after = PROMPT.predict(again, broken)
    expected, _ = PROMPT.predict(again, memory)
    assert torch.equal(action[[0, 2]], expected[[0, 2]])
    assert action[1].tolist() == [0.0, 0.0] and after["begins"].tolist() == [False, True, False]

    _, healed = PROMPT.predict(again, after)
    assert all(value.isfinite().all() for value in healed.values())
    assert torch.equal(healed["begins"], torch.zeros(3, dtype=torch.bool))


ARGUMENTS = st.none() | st.integers() | st.text(max_size=3) | st.lists(st.floats(), max_size=3)


@settings(max_examples=2 * MOST, deadline=None)
@given(bearing=ARGUMENTS, state=ARGUMENTS | st.dictionaries(st.text(max_size=2), st.integers()))
def test_wrong_arguments_are_named(bearing: Any, state: Any) -> None:
    """What is no observation or no memory is an error of the library, never a bare one."""
    reading = {"bearing": bearing, "range": np.ones(1)}
    try:
        PROMPT.predict(reading, state)
    except ObservationError:
        return
    assert state is None and np.shape(bearing) == (1,)


@pytest.mark.parametrize("start", [["a", "b"], [[True], [True, False]], torch.ones(2)])
def test_a_wrong_start_is_named(start: Any) -> None:
    reading = drifting(1, (3,))[0]
    _, memory = PROMPT.predict(reading)
    with pytest.raises(ObservationError, match="episode_start"):
        PROMPT.predict(reading, memory, episode_start=start)
