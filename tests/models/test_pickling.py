"""Policies by name can be pickled, as environments in other processes ask for."""

import pickle
from typing import Any

import pytest
import torch

from aicon_torch import make_policy

WAYS: dict[str, tuple[str, dict[str, Any]]] = {
    "navigation": ("nav2d", {}),
    "pushT, which sends places": ("pusht", {}),
    "pushT, which sends velocities": ("pusht", {"command": "velocity"}),
}


@pytest.mark.parametrize("name", WAYS)
def test_a_pickled_policy_acts_as_the_policy_does(name: str) -> None:
    task, options = WAYS[name]
    policy = make_policy(task, **options)
    copy = pickle.loads(pickle.dumps(policy))

    generator = torch.Generator().manual_seed(0)
    seen = {}
    for sensor_name, sensor in policy.model.sensors.items():
        seen[sensor.key or sensor_name] = torch.rand(sensor.size, generator=generator)

    action, _ = policy.predict(seen)
    same, _ = copy.predict(seen)
    torch.testing.assert_close(same, action, rtol=0.0, atol=0.0)
