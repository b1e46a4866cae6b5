"""The dither of the foresight: where the descent begins."""

import pytest
import torch
from _inputs import steered, walled

from aicon_torch import Actuator, Foresight, Policy, Sum
from aicon_torch.control.foresight import PRIME, scattered


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
@pytest.mark.parametrize("size", [1, 2, 7])
def test_the_dither_is_as_white_as_noise(dtype: torch.dtype, size: int) -> None:
    """Even over the range, and no step tells anything of those before it, or of its neighbours."""
    steps = torch.arange(PRIME, dtype=dtype)
    dither = scattered(steps, size)
    assert dither.abs().max() <= 1 and not dither[0].any()

    spread = dither.double()
    assert (spread.mean(0).abs() < 0.01).all()
    torch.testing.assert_close(
        spread.square().mean(0), torch.full((size,), 1 / 3).double(), atol=0.01, rtol=0
    )
    for lag in (1, 2, 5, 40):
        together = spread[lag:].T @ spread[:-lag] / len(spread)
        assert (together.abs() < 0.05).all()
    assert (torch.corrcoef(spread.T).reshape(size, size).triu(1).abs() < 0.05).all()


def test_the_dither_is_the_same_in_every_precision_and_repeats_itself() -> None:
    steps = torch.tensor([0.0, 1.0, 17.0, 4092.0, 1e6], dtype=torch.float64)
    assert torch.equal(scattered(steps, 3).float(), scattered(steps.float(), 3))
    torch.testing.assert_close(scattered(steps + PRIME, 3), scattered(steps, 3))


def test_every_descent_begins_elsewhere_within_its_share_of_the_limit() -> None:
    last, steps = torch.zeros(500, 2, dtype=torch.float64), torch.arange(500).double()
    starts = Foresight(dither=0.2).start(last, steps, Actuator(2, "m", (1.0, 3.0)))
    assert (starts.abs().max(0).values - torch.tensor([0.2, 0.6])).abs().max() < 0.01
    assert starts.unique(dim=0).shape == starts.shape
    assert not Foresight(dither=0).start(last, steps, Actuator(2, "m", 0.5)).any()


def test_a_dither_is_a_mixture_of_the_actuators_own_motions() -> None:
    last, steps = torch.zeros(500, 3, dtype=torch.float64), torch.arange(500).double()
    motion = torch.tensor([[0.3], [0.0], [-0.4]], dtype=torch.float64)
    starts = Foresight(dither=0.5).start(last, steps, Actuator(3, "rad/s", 2.0), motion)

    shares = starts @ motion / 0.25
    assert abs(float(shares.abs().max()) - 0.5) < 0.01
    torch.testing.assert_close(starts, shares @ motion.mT)


def test_a_dither_stays_for_its_steps() -> None:
    last, steps = torch.zeros(60, 2, dtype=torch.float64), torch.arange(60).double()
    starts = Foresight(dither_steps=5).start(last, steps, Actuator(2, "m", 1.0)).reshape(12, 5, 2)
    assert torch.equal(starts, starts[:, :1].expand_as(starts))
    assert starts[:, 0].unique(dim=0).shape == (12, 2)


def test_a_component_that_nothing_pulls_goes_back_to_rest() -> None:
    law, actuator = Foresight(step=0.4), Actuator(2, "m/s", (0.5, 0.5))
    action = torch.tensor([0.3, 0.1], dtype=torch.float64)
    gradient = torch.tensor([0.0, 2.0], dtype=torch.float64)
    nearer = law.descend(action, gradient, torch.tensor(2.0), actuator)
    torch.testing.assert_close(nearer, torch.tensor([0.2, 0.0], dtype=torch.float64))


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_what_rounding_leaves_of_a_gradient_pulls_nothing(dtype: torch.dtype) -> None:
    law, actuator = Foresight(), Actuator(2, "rad/s", limit=1.0)
    first, action = torch.tensor(1.0, dtype=dtype), torch.tensor([0.0, 0.3], dtype=dtype)
    left = 4 * torch.finfo(dtype).eps
    for sign in (-1.0, 1.0):
        gradient = torch.tensor([1.0, sign * left], dtype=dtype)
        assert law.descend(action, gradient, first, actuator)[1] == 0.0


def test_a_robot_that_nothing_pulls_rests() -> None:
    policy = Policy(steered(goal=(3.0, -1.0)).model, Sum(), Foresight(smoothing=0.0))
    readings = walled(60)
    _, memory = policy.predict(readings[0])
    memory = policy.switch(memory, reach=0)
    for reading in readings[1:]:
        action, memory = policy.predict(reading, memory)
        assert float(action.norm()) < 1e-9
