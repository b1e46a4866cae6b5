"""A rollout that explores, and what the policy followed in it."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from torch import Tensor

from aicon_baselines.figures.nav2d import NavigationRecording, record
from aicon_torch import Policy, make_policy
from aicon_torch.control import DirectDescent

MAP, SEED = "u_trap_05", 1000


@pytest.fixture(scope="session")
def followed() -> tuple[NavigationRecording, list[NDArray[np.float64]]]:
    """A rollout with one gradient a step, and that gradient of each step at the action, by m."""
    gradients: list[NDArray[np.float64]] = []

    policy = make_policy("nav2d")

    class NotingLaw(DirectDescent):
        def descend(self, action: Tensor, gradient: Tensor, *others: Any) -> Tensor:
            gradients.append(gradient.numpy() / policy.model.dt)
            return super().descend(action, gradient, *others)

    law = NotingLaw(gain=20.0)
    noting_policy = Policy(policy.model, policy.resolution, law)
    return record(noting_policy, MAP, SEED), gradients


@pytest.fixture
def recording(
    followed: tuple[NavigationRecording, list[NDArray[np.float64]]],
) -> NavigationRecording:
    return followed[0]
