"""Exported and compiled policies and their memory can be saved, pickled and copied."""

import copy
import io
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from _asserts import assert_same_memory
from _inputs.following import follower, wandering

from aicon_torch import ExportedPolicy, Policy, load_exported
from aicon_torch.export.codegen import has_compiler

pytestmark = pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")


def pickled(value: Any) -> Any:
    return pickle.loads(pickle.dumps(value))


def saved(value: Any) -> Any:
    """Through torch.save and torch.load as they are by default: tensors, and no code."""
    buffer = io.BytesIO()
    torch.save(value, buffer)
    return torch.load(io.BytesIO(buffer.getvalue()))


@pytest.fixture(scope="module", params=["exported", "compiled"])
def policy(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Any:
    readable = follower()
    if request.param == "compiled":
        return readable.compile()
    path = tmp_path_factory.mktemp("exported") / "policy.so"
    readable.export(path)
    return load_exported(path)


@pytest.mark.parametrize("copied", [saved, pickled, copy.copy, copy.deepcopy])
def test_a_memory_goes_on_where_it_was(policy: Any, copied: Callable[[Any], Any]) -> None:
    first, second = wandering(2, (3,))
    _, memory = policy.predict(first)
    kept = copied(memory)
    assert_same_memory(kept, memory, 0.0)

    _, expected = policy.predict(second, memory)
    _, found = policy.predict(second, kept)
    assert_same_memory(found, expected, 0.0)


@pytest.mark.parametrize("copied", [pickled, copy.copy, copy.deepcopy])
def test_a_policy_takes_the_same_steps(policy: Any, copied: Callable[[Any], Any]) -> None:
    first, second = wandering(2)
    _, memory = policy.predict(first)
    expected, _ = policy.predict(second, memory)

    same = copied(policy)
    assert isinstance(same, (ExportedPolicy, Policy))
    np.testing.assert_array_equal(same.predict(second, memory)[0], expected)
    np.testing.assert_array_equal(same.predict(second, same.predict(first)[1])[0], expected)


def test_a_copied_memory_is_its_own(policy: Any) -> None:
    _, memory = policy.predict(wandering(1)[0])
    kept = copy.deepcopy(memory)
    before = {name: value.clone() for name, value in memory.items()}
    kept.flat[:] = 0.0
    assert_same_memory(memory, before, 0.0)


def test_a_pickled_policy_needs_no_file(tmp_path: Path) -> None:
    path = tmp_path / "policy.so"
    follower().export(path, task="some task")
    kept = pickle.dumps(load_exported(path))
    path.unlink()

    policy = pickle.loads(kept)
    assert policy.metadata["description"] == {"task": "some task"}
    policy.act(wandering(1)[0])


def test_a_factor_that_requires_a_gradient_is_a_number(policy: Any) -> None:
    first, second = wandering(2)
    _, memory = policy.predict(first)
    factor = torch.tensor(0.5, requires_grad=True)
    found, _ = policy.predict(second, policy.switch(memory, near=factor))
    expected, _ = policy.predict(second, policy.switch(memory, near=0.5))
    torch.testing.assert_close(found, expected, rtol=0, atol=0)
