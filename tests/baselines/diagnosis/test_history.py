"""A history is what the policy's memories say, in an episode that was really run."""

from collections.abc import Callable

import numpy as np
import pytest
import torch
from torch import Tensor

from aicon_baselines.diagnosis import History, Recording, diagnose
from aicon_torch import (
    Actuator,
    Affine,
    Foresight,
    Goal,
    KalmanFilter,
    Measurement,
    Policy,
    Sensor,
    WorldModel,
)
from aicon_torch.parts import clock
from aicon_torch.resolution import Memory

STEPS = 60


def to_the_left(x: Tensor) -> Tensor:
    return (x - x.new_tensor([-1.0, 0.0])).norm(dim=-1)


def to_the_right(x: Tensor) -> Tensor:
    return (x - x.new_tensor([1.0, 0.0])).norm(dim=-1)


def torn_policy() -> Policy:
    """A point that wants to be in two places."""
    sight = Measurement(Affine(x=1.0, z=-1.0), noise=0.01**2, size=2)
    place = KalmanFilter(
        "x",
        "P",
        predict=Affine(x=1.0, a=0.1),
        noise=1e-6,
        initial=((0.0, 0.0), 1.0),
        correct=[sight],
    )
    model = WorldModel(
        sensors={"z": Sensor(2, "m", optional=True), "z_elapsed": clock()},
        actuators={"a": Actuator(2, "m/s", limit=0.5)},
        estimators=[place],
        goals=[Goal("left", to_the_left), Goal("right", to_the_right)],
        dt=0.1,
        clock="z_elapsed",
        dtype=torch.float64,
    )
    return Policy(model, law=Foresight(iterations=2))


def run(read: Callable[[Tensor, int], Tensor]) -> Recording:
    """An episode with these readings of the place, at some step."""
    policy = torn_policy()
    memories: list[Memory] = []
    memory = None
    place = torch.tensor([0.05, 0.0], dtype=torch.float64)
    for step in range(STEPS):
        action, memory = policy.predict({"z": read(place, step)}, memory)
        memories.append(memory)
        place = place + 0.1 * action
    return Recording(policy, memories, success=False)


@pytest.fixture(scope="module")
def torn() -> History:
    return History.of(run(lambda place, _: place))


def test_it_has_a_curve_for_every_part_of_the_graph(torn: History) -> None:
    assert torn.steps == STEPS
    assert set(torn.costs) == {"left", "right"}
    assert torn.meetings["x"].goals == ("left", "right")
    assert torn.actuators["a"].share.shape == (STEPS, 1)
    assert [innovation.readings for innovation in torn.innovations] == [("z",)]
    assert torn.times[-1] == pytest.approx((STEPS - 1) * 0.1)


def test_a_clock_that_nobody_reads_is_no_silence(torn: History) -> None:
    assert set(torn.present) == {"z"}
    assert "silence" not in {cause.kind for cause in diagnose(torn).causes}


def test_the_conflict_of_its_goals_is_found(torn: History) -> None:
    kinds = {cause.kind: cause for cause in diagnose(torn).causes}
    assert set(kinds["conflict"].subjects) == {"left", "right"}


def test_innovations_are_small_where_the_model_is_right(torn: History) -> None:
    (innovation,) = torn.innovations
    assert np.nanmax(innovation.squared) < 1.0


def test_a_place_that_slips_away_disagrees_with_the_model() -> None:
    drift = torch.tensor([0.0, 0.05], dtype=torch.float64)
    slipping = run(lambda place, step: place + step * drift)
    assert "disagreement" in {cause.kind for cause in diagnose(slipping).causes}


def test_readings_that_stop_are_silence_and_no_disagreement() -> None:
    nothing = torch.full((2,), torch.nan, dtype=torch.float64)
    blind = run(lambda place, step: place if step < 20 else nothing)

    kinds = {cause.kind for cause in diagnose(blind).causes}
    assert "silence" in kinds
    assert "disagreement" not in kinds


def test_a_row_of_a_batch_is_asked_for() -> None:
    policy = torn_policy()
    _, memory = policy.predict({"z": torch.zeros(3, 2, dtype=torch.float64)})
    with pytest.raises(ValueError, match="take one row"):
        diagnose(Recording(policy, [memory, memory]))
    with pytest.raises(ValueError, match="two steps or more"):
        diagnose(Recording(policy, [memory]))
