import pytest
import torch
from _inputs import normal

from aicon_torch import OptionError
from aicon_torch.parts.velocity_lag import VelocityLag

STEP = torch.tensor(0.01, dtype=torch.float64)  # s


def test_the_velocity_follows_an_even_command_as_the_differential_equation_says() -> None:
    lag, a = VelocityLag(3, time_constant=0.1).double(), normal(5, 3, seed=1)
    v = lag.initial({})["v_joints"].expand(5, 3)
    for _ in range(7):
        v = lag.update({"v_joints": v, "a": a, "dt": STEP})["v_joints"]
    followed = 1 - torch.exp(torch.tensor(-0.7, dtype=torch.float64))
    torch.testing.assert_close(v, followed * a)


def test_one_long_step_is_as_good_as_many_short_ones() -> None:
    lag, a, v = VelocityLag(3, time_constant=0.1).double(), normal(2, 3, seed=2), normal(2, 3)
    once = lag.update({"v_joints": v, "a": a, "dt": torch.tensor([[0.03], [0.01]])})["v_joints"]
    for _ in range(3):
        v = lag.update({"v_joints": v, "a": a, "dt": STEP})["v_joints"]
    torch.testing.assert_close(once[0], v[0], rtol=1e-6, atol=0)


def test_what_is_foreseen_is_the_command() -> None:
    lag, a = VelocityLag(3, time_constant=0.1), normal(3).requires_grad_()
    (gradient,) = torch.autograd.grad(lag({"a": a}, "v_joints").sum(), a)
    assert gradient.eq(1).all()


@pytest.mark.parametrize("wrong", [0.0, -0.1, float("nan")])
def test_a_time_constant_is_positive(wrong: float) -> None:
    with pytest.raises(OptionError, match="time_constant"):
        VelocityLag(3, wrong)
