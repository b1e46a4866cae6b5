"""A memory goes on in a policy of another precision; what is no real number there is refused."""

import io
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import pytest
import torch
from _asserts import assert_same_memory
from _inputs import navigation, observation_with
from _inputs.following import follower, wandering
from torch import Tensor

from aicon_torch import ObservationError, load_exported
from aicon_torch.export.codegen import has_compiler

Memory = Mapping[str, Tensor]


@pytest.fixture(scope="module", params=["readable", "compiled", "exported"])
def policy(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Any:
    """In double precision."""
    readable = follower()
    if request.param == "readable":
        return readable
    if not has_compiler():
        pytest.skip("there is no C compiler")
    if request.param == "compiled":
        return readable.compile()

    path = tmp_path_factory.mktemp("exported") / "policy.so"
    readable.export(path)
    return load_exported(path)


def converted(memory: Memory, dtype: torch.dtype) -> dict[str, Tensor]:
    """Its real numbers in another precision, saved and loaded."""
    changed: dict[str, Tensor] = {}
    for key, value in memory.items():
        changed[key] = value.to(dtype) if value.is_floating_point() else value.clone()

    buffer = io.BytesIO()
    torch.save(changed, buffer)
    loaded: dict[str, Tensor] = torch.load(io.BytesIO(buffer.getvalue()))
    return loaded


@pytest.mark.parametrize("dtype", [torch.float32, torch.bfloat16], ids=str)
def test_a_memory_of_another_precision_goes_on(policy: Any, dtype: torch.dtype) -> None:
    first, second = wandering(2, (3,))
    _, memory = policy.predict(first)
    rounded = converted(memory, dtype)

    # As one of this precision with the same numbers does.
    _, expected = policy.predict(second, converted(rounded, torch.float64))
    _, found = policy.predict(second, rounded)
    assert_same_memory(found, expected, 0.0)
    assert found["p"].dtype == torch.float64

    switched = policy.switch(rounded, near=0.5)
    assert_same_memory(policy.switch(converted(rounded, torch.float64), near=0.5), switched, 0.0)


def test_what_is_read_off_a_memory_is_so_in_any_precision() -> None:
    policy = follower()
    _, memory = policy.predict(wandering(1)[0])
    rounded = converted(memory, torch.float32)
    widened = converted(rounded, torch.float64)
    assert str(policy.explain(rounded)) == str(policy.explain(widened))
    assert torch.equal(policy.trace(rounded).costs["near"], policy.trace(widened).costs["near"])


def wrong_types(memory: Memory) -> Iterator[tuple[str, Tensor]]:
    """Each entry in types that it cannot have."""
    for key, value in memory.items():
        others: list[Callable[[Tensor], Tensor]] = [lambda v: v.to(torch.complex64)]
        if value.is_floating_point():
            others += [lambda v: v.to(torch.int64), lambda v: v > 0]
        else:
            others += [lambda v: v.to(torch.float64)]
        for other in others:
            yield key, other(value)


def test_other_types_are_refused_by_name(policy: Any) -> None:
    first, second = wandering(2)
    _, memory = policy.predict(first)
    for key, wrong in wrong_types(memory):
        told = rf"state\['{key}'\]: expected .*, got {wrong.dtype}"
        with pytest.raises(ObservationError, match=told):
            policy.predict(second, {**memory, key: wrong})
        with pytest.raises(ObservationError, match=told):
            policy.switch({**memory, key: wrong}, near=0.5)


def test_other_types_are_refused_where_gradients_meet_as_well() -> None:
    policy = navigation()
    _, memory = policy.predict(observation_with())
    assert {value.dtype for value in memory.values()} >= {torch.bool, torch.int64}
    for key, wrong in wrong_types(memory):
        with pytest.raises(ObservationError, match=rf"state\['{key}'\]"):
            policy.predict(observation_with(), {**memory, key: wrong})
