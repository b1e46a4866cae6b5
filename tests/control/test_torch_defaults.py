"""Torch's defaults and modes are the user's: no policy depends on them."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest
import torch
from _asserts import assert_same_memory, rollout
from _inputs import drifting, driven, lean, lean_anew
from _inputs.pushing import wandering
from _inputs.reaching import planar_arm
from torch import Tensor

from aicon_torch import Policy
from aicon_torch.export.codegen import has_compiler

ARM = planar_arm()


def arm(count: int) -> list[dict[str, Tensor]]:
    """Readings of a planar arm that turns, near a ball."""
    place = {"target_position": torch.tensor([0.3, 0.4, 0.0], dtype=torch.float64)}
    place["ball_1"] = torch.tensor([0.4, 0.2, 0.0], dtype=torch.float64)
    turning = torch.tensor([0.1, 0.0, 0.0], dtype=torch.float64)
    start = torch.tensor([0.0, 0.5, -0.4], dtype=torch.float64)
    return [{"q": start + step * turning, **place} for step in range(count)]


POLICIES: dict[str, tuple[Callable[[], Policy], list[dict[str, Tensor]]]] = {
    "nav2d": (lambda: lean_anew("nav2d", max_speed=0.3), drifting(4, (2,))),
    "pusht": (lambda: lean_anew("pusht"), wandering(2, 2)),
    "reach": (lambda: lean_anew("reach", robot=ARM, balls=1), arm(2)),
}


@contextmanager
def defaults(dtype: torch.dtype, device: str | None) -> Iterator[None]:
    """Torch's defaults for a while."""
    usual = torch.get_default_dtype()
    torch.set_default_dtype(dtype)
    torch.set_default_device(device)
    try:
        yield
    finally:
        torch.set_default_dtype(usual)
        torch.set_default_device(None)


every_policy = pytest.mark.parametrize(("build", "readings"), POLICIES.values(), ids=POLICIES)
other_defaults = pytest.mark.parametrize(
    ("dtype", "device"),
    [(torch.float16, None), (torch.float64, None), (torch.float32, "meta")],
    ids=str,
)


@every_policy
@other_defaults
def test_a_policy_steps_as_ever(
    build: Callable[[], Policy],
    readings: list[dict[str, Tensor]],
    dtype: torch.dtype,
    device: str | None,
) -> None:
    policy = build()
    expected = rollout(policy, readings)
    with defaults(dtype, device):
        found = rollout(policy, readings)
    assert_same_memory(found[-1], expected[-1], 0.0)


@every_policy
@other_defaults
def test_nor_does_it_matter_what_they_were_when_it_was_built(
    build: Callable[[], Policy],
    readings: list[dict[str, Tensor]],
    dtype: torch.dtype,
    device: str | None,
) -> None:
    expected = rollout(build(), readings)
    with defaults(dtype, device):
        policy = build()
    assert_same_memory(rollout(policy, readings)[-1], expected[-1], 0.0)


@other_defaults
def test_what_is_done_with_a_memory_does_not_depend_on_them(
    dtype: torch.dtype, device: str | None
) -> None:
    readings = drifting(2)
    arrays = [{key: value.numpy() for key, value in reading.items()} for reading in readings]
    for form in (lean("nav2d"), driven("nav2d")):
        _, memory = form.predict(arrays[0])
        expected = form.predict(arrays[1], form.switch(memory, reach=0.3))[1]
        with defaults(dtype, device):
            found = form.predict(arrays[1], form.switch(memory, reach=0.3), episode_start=False)[1]
            watched = form.estimate(arrays[1], memory)
            form.explain(found)
        assert_same_memory(found, expected, 0.0)
        assert_same_memory(watched, form.estimate(arrays[1], memory), 0.0)


@every_policy
def test_nothing_is_rounded_in_autocast_but_what_a_perception_does(
    build: Callable[[], Policy], readings: list[dict[str, Tensor]]
) -> None:
    policy = build().float()
    policy.perception = lambda observation, values, starts: seen.append(low()) or observation
    seen: list[bool] = []

    def low() -> bool:
        return torch.is_autocast_enabled("cpu")

    expected = rollout(policy, readings)
    assert not any(seen)
    with torch.autocast("cpu"):
        found = rollout(policy, readings)
        explained = policy.explain(found[-1], row=(0,) * found[-1]["begins"].dim())
        assert seen[-1] and low()
    assert_same_memory(found[-1], expected[-1], 0.0)
    assert explained == policy.explain(expected[-1], row=(0,) * expected[-1]["begins"].dim())


@pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")
def test_nor_where_a_policy_is_compiled_or_built() -> None:
    readings = drifting(2)
    expected = rollout(lean_anew("nav2d").float().compile(), readings)
    with torch.autocast("cpu"):
        found = rollout(lean_anew("nav2d").float().compile(), readings)
    assert_same_memory(dict(found[-1]), dict(expected[-1]), 0.0)
