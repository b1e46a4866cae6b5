"""An exported policy takes the steps of the one that it was exported from."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from _asserts import assert_same_memory, assert_same_steps
from _inputs import drifting, observation_with
from _inputs.exported_files import REFUSED, write_wrong_file

from aicon_torch import (
    ExportedPolicy,
    Foresight,
    ObservationError,
    OptionError,
    Policy,
    load_exported,
    make_policy,
)
from aicon_torch.export.codegen import has_compiler

pytestmark = pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")

Pair = tuple[Policy, ExportedPolicy]

NAVIGATION = make_policy("nav2d", law=Foresight(iterations=2))


def exported(policy: Policy, folder: Path) -> ExportedPolicy:
    """The policy, exported and loaded."""
    policy.export(folder / "policy.so", task="some task")
    return load_exported(folder / "policy.so")


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The navigation's policy as a library, beside its source."""
    folder = tmp_path_factory.mktemp("good")
    for name in ("good.so", "good.c"):
        NAVIGATION.export(folder / name, task="some task")
    return folder / "good.so"


@pytest.fixture(scope="module")
def pair(good: Path) -> Pair:
    return NAVIGATION, load_exported(good)


def test_it_takes_the_same_steps(pair: Pair) -> None:
    assert_same_steps(*pair, drifting(20))


def test_it_takes_them_for_any_batch(pair: Pair) -> None:
    assert_same_steps(*pair, drifting(5, (2, 3)))


@pytest.mark.slow
@pytest.mark.usefixtures("optimized")
@pytest.mark.parametrize("dtype", [torch.float64, torch.float32])
def test_it_takes_the_same_steps_as_shipped(dtype: torch.dtype, tmp_path: Path) -> None:
    policy = make_policy("nav2d", dtype=dtype)
    assert_same_steps(policy, exported(policy, tmp_path), drifting(100))


def test_a_memory_of_another_precision_is_converted(pair: Pair, tmp_path: Path) -> None:
    single = make_policy("nav2d", law=Foresight(iterations=2), dtype=torch.float32)
    observation = observation_with(range=np.array([1.0]))
    _, memory = exported(single, tmp_path).predict(observation)

    _, found = pair[1].predict(observation, memory)
    _, expected = pair[1].predict(observation, dict(memory))
    assert_same_memory(found, expected, 0.0)


def test_arrays_give_the_same_as_tensors_quickly_or_not(pair: Pair) -> None:
    """The quick way of one robot's arrays, and the way that takes anything."""
    policy, found = pair
    observations = [observation_with(range=np.array([1.0 - 0.01 * step])) for step in range(10)]

    quick, careful, expected = None, None, None
    for observation in observations:
        action, quick = found.predict(observation, quick)
        as_lists: dict[str, Any] = {key: value.tolist() for key, value in observation.items()}
        same, careful = found.predict(as_lists, careful)
        readable, expected = policy.predict(observation, expected)

        assert action.dtype == same.dtype == readable.dtype == np.float32
        np.testing.assert_array_equal(action, same)
        np.testing.assert_allclose(action, readable, rtol=1e-6, atol=1e-6)


def test_a_step_is_quick_without_what_is_optional(
    pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nobody says how long the last step took, and the readings are not gone through in torch."""
    _, found = pair
    observation = observation_with(range=np.array([1.0]))
    _, memory = found.predict(observation)
    expected, _ = found.predict(observation, memory)

    monkeypatch.setattr(found, "_checked", None)
    np.testing.assert_array_equal(found.predict(observation, memory)[0], expected)


def test_no_step_changes_a_memory(pair: Pair) -> None:
    _, found = pair
    _, memory = found.predict(observation_with())
    before = memory.flat.copy()

    for _ in range(2):
        found.predict(observation_with(), memory)
    np.testing.assert_array_equal(memory.flat, before)


def test_rows_that_start_begin_anew_and_goals_stay_switched(pair: Pair) -> None:
    policy, found = pair
    first, second = drifting(2, (3,))
    starts = torch.tensor([False, True, False])

    _, memory = policy.predict(first)
    memory = policy.switch(memory, avoid=0.5)
    _, expected = policy.predict(second, memory, starts)

    _, same = found.predict(first)
    same = found.switch(same, avoid=0.5)
    _, after = found.predict(second, same, starts)
    assert_same_memory(after, expected, 1e-10)


def test_its_memory_is_read_like_the_other_and_explained_by_the_policy(pair: Pair) -> None:
    policy, found = pair
    _, memory = found.predict(observation_with())
    _, expected = policy.predict(observation_with())

    assert set(memory) == set(expected)
    assert all(memory[name].dtype == expected[name].dtype for name in memory)
    assert str(policy.explain(dict(memory))) == str(policy.explain(expected))


@pytest.mark.parametrize(
    "wrong",
    [
        {"bearing": np.array([1.0, 2.0])},
        {"bearing": np.array([[1.0]])},
        {"bearing": np.array(["left"])},
        {"bearing": None},
    ],
    ids=str,
)
def test_it_refuses_what_the_policy_refuses_in_the_same_words(
    pair: Pair, wrong: dict[str, Any]
) -> None:
    policy, found = pair
    _, memory = found.predict(observation_with())
    with pytest.raises(ObservationError) as expected:
        policy.predict(observation_with(**wrong))

    for state in (None, memory):
        with pytest.raises(ObservationError) as raised:
            found.predict(observation_with(**wrong), state)
        assert str(raised.value) == str(expected.value)


def test_it_refuses_the_memory_of_another_batch(pair: Pair) -> None:
    _, found = pair
    _, memory = found.predict(drifting(1, (3,))[0])
    with pytest.raises(ObservationError, match="batch"):
        found.predict(observation_with(), memory)


def test_it_says_what_it_is(pair: Pair) -> None:
    metadata = pair[1].metadata
    assert metadata["description"] == {"task": "some task"}
    assert metadata["iterations"] == 2 and metadata["dtype"] == "float64"
    assert [sensor["key"] for sensor in metadata["sensors"]] == ["bearing", "range", "elapsed"]


def test_a_source_is_complete(good: Path) -> None:
    text = good.with_suffix(".c").read_text()
    assert "aicon_step" in text and "torch/" not in text
    assert {line for line in text.splitlines() if line.startswith("#include")} == {
        "#include <math.h>",
        "#include <string.h>",
    }


def test_the_name_tells_what_to_write(tmp_path: Path) -> None:
    with pytest.raises(OptionError, match=r"policy.pt2.*ends in \.so"):
        make_policy("nav2d").export(tmp_path / "policy.pt2")
    with pytest.raises(OptionError, match="path=3: expected the name of a file"):
        make_policy("nav2d").export(3)  # type: ignore[arg-type]


@pytest.mark.parametrize(("name", "words"), REFUSED.items())
def test_wrong_files_are_refused(name: str, words: str, good: Path, tmp_path: Path) -> None:
    path = write_wrong_file(name, good, tmp_path)
    with pytest.raises(OptionError, match=words) as raised:
        load_exported(path)
    assert str(path) in str(raised.value)


def test_without_a_compiler_it_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(OptionError, match="no C compiler 'no-such-compiler'"):
        NAVIGATION.export(tmp_path / "policy.so")
