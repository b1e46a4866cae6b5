"""Memory goes in and comes out: rows and episodes are independent of each other."""

import io
from typing import Any

import numpy as np
import pytest
import torch
from _asserts import assert_rows_stand_alone, assert_same_memory, rollout
from _inputs import (
    MOVE,
    as_arrays,
    drifting,
    lean,
    lean_anew,
    navigation,
    near,
    observation_with,
    tracked_point,
    tracking_model,
    with_rule,
)
from torch import Tensor

from aicon_torch import Actuator, Goal, Measurement, ObservationError, Policy
from aicon_torch.control.foresight import PRIME
from aicon_torch.control.memory import STEPS_AT_MOST
from aicon_torch.models import presets


@pytest.mark.parametrize("preset", ["aicon", "paper_literal", "steepest", "potential_field"])
def test_singles_are_rows_of_a_batch(preset: str) -> None:
    assert_rows_stand_alone(navigation(preset), drifting(20, (3,)), rows=(0, 2))


def test_singles_are_rows_of_a_batch_without_a_softmax() -> None:
    policy = with_rule(navigation(), temperature=None)
    assert_rows_stand_alone(policy, drifting(20, (3,)), rows=(0, 2))


def test_the_batch_may_have_any_number_of_dimensions() -> None:
    recorded = drifting(20, (2, 3))
    _, memory = navigation().predict(recorded[0])
    assert all(value.shape[:2] == (2, 3) for value in memory.values())
    assert_rows_stand_alone(navigation(), recorded, rows=((0, 0), (1, 2)))


def test_the_recorded_readings_make_it_explore() -> None:
    """Else the tests above and below would show little."""
    memories = rollout(navigation(), drifting(20, (3,)))
    exploring = torch.stack([memory["x_rob/exploring"] for memory in memories])
    assert 0.05 < exploring.double().mean() < 0.95


@pytest.mark.parametrize("preset", ["aicon", "paper_literal", "steepest"])
def test_an_episode_goes_on_after_saving_and_loading(preset: str) -> None:
    policy, recorded = navigation(preset), drifting(24)
    straight = rollout(policy, recorded)

    saved = io.BytesIO()
    torch.save(straight[15], saved)
    saved.seek(0)
    memory = torch.load(saved, weights_only=True)

    other = lean_anew("nav2d", preset=preset)
    for reading, expected in zip(recorded[16:], straight[16:], strict=True):
        _, memory = other.predict(reading, memory)
        assert_same_memory(memory, expected, 0.0)


def test_a_count_of_steps_begins_anew_where_single_precision_ends() -> None:
    policy, recorded = navigation(), drifting(2)
    _, memory = policy.predict(recorded[0])
    memory["steps"] = torch.full_like(memory["steps"], STEPS_AT_MOST - 1)
    _, after = policy.predict(recorded[1], memory)
    assert after["steps"] == 0 and STEPS_AT_MOST < 2**24 and STEPS_AT_MOST % PRIME == 0


@pytest.mark.parametrize("derivative", ["model", "update", "detached_gain"])
def test_no_graph_stays_in_the_memory_beside_a_safety_goal(derivative: Any) -> None:
    def bent(p: Tensor, z: Tensor) -> Tensor:
        return p + 0.1 * p**3 - z

    point = tracked_point(correct=[Measurement(bent, 0.1, size=2)], derivative=derivative)
    kept = Goal("kept", lambda x: x.square().sum(-1) - 1.0, safety=True)
    actuators = {"a": Actuator(2, "m/s", limit=1.0)}
    model = tracking_model(MOVE, point, goals=[Goal("near", near), kept], actuators=actuators)
    policy, memory = Policy(model), None
    for _ in range(2):
        _, memory = policy.predict({"z": torch.ones(2, dtype=torch.float64)}, memory)
        assert not any(value.requires_grad for value in memory.values())


@pytest.mark.parametrize("preset", presets("nav2d"))
def test_the_memory_is_flat_and_carries_no_graph(preset: str) -> None:
    for memory in rollout(navigation(preset), drifting(3, (2,))):
        for value in memory.values():
            assert isinstance(value, Tensor) and not value.requires_grad
            assert value.shape[0] == 2


def test_predict_does_not_change_what_it_is_given() -> None:
    recorded = drifting(15, (2,))
    memory = rollout(navigation(), recorded)[-1]
    before = {key: value.clone() for key, value in memory.items()}

    navigation().predict(recorded[0], memory, episode_start=torch.tensor([True, False]))
    navigation().switch(memory, reach=False)

    assert_same_memory(memory, before, 0.0)


def test_act_and_reset_are_predict_with_the_memory_kept() -> None:
    policy = lean("nav2d")

    for _ in range(2):
        memory = None
        for reading in drifting(14):
            action, memory = policy.predict(as_arrays(reading), memory)
            assert np.array_equal(policy.act(as_arrays(reading)), action)

        policy.reset()


def test_one_policy_serves_several_episodes_at_once() -> None:
    """No step leaves anything behind in the policy."""
    policy, first, second = navigation(), drifting(26, seed=1), drifting(26, seed=5)
    alone = rollout(policy, first)
    memories: list[Any] = [None, None]

    for step in range(26):
        for episode, recorded in enumerate((first, second)):
            _, memories[episode] = policy.predict(recorded[step], memories[episode])
        assert_same_memory(memories[0], alone[step], 0.0)


# --- what does not fit


@pytest.mark.parametrize(
    ("batch", "other"), [((), (3,)), ((3,), ()), ((3,), (2,)), ((2, 3), (6,))], ids=str
)
def test_a_memory_of_another_batch_is_named(batch: tuple[int, ...], other: tuple[int, ...]) -> None:
    _, memory = navigation().predict(drifting(1, batch)[0])
    with pytest.raises(ObservationError, match=r"state.*\(.*\).*\(.*\)"):
        navigation().predict(drifting(1, other)[0], memory)


def test_a_memory_of_another_policy_is_named() -> None:
    _, memory = navigation("steepest").predict(observation_with())
    with pytest.raises(ObservationError, match=r"state.*lacks .*'x_rob/exploring'.*'a/gradients'"):
        navigation().predict(observation_with(), memory)

    incomplete = {key: value for key, value in memory.items() if key != "p_tar"}
    with pytest.raises(ObservationError, match="'p_tar'"):
        navigation().predict(observation_with(), incomplete)
