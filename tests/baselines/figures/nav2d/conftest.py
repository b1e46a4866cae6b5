"""A rollout that explores, and what the policy followed in it."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from aicon_baselines.figures.nav2d import NavigationRecording, record
from aicon_torch import Policy, make_policy
from aicon_torch.control import DirectDescent

MAP, SEED = "u_trap_05", 1000


@pytest.fixture(scope="session")
def followed() -> tuple[NavigationRecording, list[NDArray[np.float64]]]:
    """A rollout, and the gradient at the action that the policy followed in each step, by m."""
    gradients: list[NDArray[np.float64]] = []

    class NotingLaw(DirectDescent):
        def __call__(self, gradient: Any, *others: Any) -> Any:
            *_, dt = others
            gradients.append(gradient.numpy() / dt)
            return super().__call__(gradient, *others)

    policy = make_policy("nav2d")
    law = NotingLaw(**vars(policy.law))
    noting_policy = Policy(policy.model, policy.resolution, law)
    return record(noting_policy, MAP, SEED), gradients


@pytest.fixture
def recording(
    followed: tuple[NavigationRecording, list[NDArray[np.float64]]],
) -> NavigationRecording:
    return followed[0]
