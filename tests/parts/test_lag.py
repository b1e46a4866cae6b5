"""A robot that follows its command with a lag."""

import pytest
import torch

from aicon_torch import OptionError
from aicon_torch.parts import Lag


@pytest.mark.parametrize("duration", [0.01, 0.3])
def test_the_displacement_is_that_of_its_equation_of_motion(duration: float) -> None:
    told, velocity, place = 1.0, -0.5, 0.0
    for _ in range(20_000):
        velocity += (told - velocity) / 0.1 * duration / 20_000
        place += velocity * duration / 20_000

    a, v, dt = (torch.tensor(x, dtype=torch.float64) for x in ([told], [-0.5], duration))
    assert float(Lag(0.1).displacement(a, v, dt)) == pytest.approx(place, rel=1e-3)


def test_a_lag_is_positive() -> None:
    with pytest.raises(OptionError, match="time"):
        Lag(0.0)
