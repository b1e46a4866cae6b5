"""Every model stands soon after its readings are gone or frozen, and goes on when they are back."""

from typing import Any

import pytest
import torch
from _inputs import drifting, lean
from _inputs.pushing import wandering
from _inputs.reaching import planar_arm
from torch import Tensor

from aicon_torch import Policy

Reading = dict[str, Tensor]


def arm_readings(count: int) -> list[Reading]:
    """Joints that turn slowly, an object and its target that lie still."""
    readings: list[Reading] = []
    for step in range(count):
        turned = torch.tensor([0.0, 0.2, 0.0, -2.2, 0.0, 2.4, 0.8]) + 1e-3 * step
        place = torch.tensor([0.5, 0.0, 0.3])
        target = torch.tensor([0.55, 0.1, 0.0])
        readings.append({"q": turned[None], "object_pose": place[None], "target": target[None]})
    return readings


def reaching_readings(count: int) -> list[Reading]:
    """The joints of three links that turn slowly, a target and a ball out of the way."""
    readings: list[Reading] = []
    for step in range(count):
        turned = torch.tensor([[0.5, 1.0, 0.3]]) + 1e-3 * step
        place, ball = torch.tensor([[-0.3, 0.4, 0.0]]), torch.tensor([[4.0, 4.0, 0.0]])
        readings.append({"q": turned, "target_position": place, "ball_1": ball})
    return readings


ARM = planar_arm()
MODELS = {
    "nav2d": (lambda: lean("nav2d"), drifting(14, (1,)), 6),
    "nav2d, late": (lambda: lean("nav2d", delay=10), drifting(14, (1,)), 6),
    "pusht": (lambda: lean("pusht"), wandering(12, 1), 3),
    "pusht, late": (lambda: lean("pusht", delay=3), wandering(12, 1), 3),
    "arm_push": (lambda: lean("arm_push", sensing="pose"), arm_readings(18), 10),
    "reach": (lambda: lean("reach", robot=ARM, balls=1), reaching_readings(14), 6),
    "arm_push, late": (lambda: lean("arm_push", sensing="pose", delay=10), arm_readings(18), 10),
}
"""What makes a policy, readings, and the number of steps after which it must stand."""

each_model = pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=[pytest.mark.slow] * (n == "arm_push, late")) for n in MODELS],
)


def blind(reading: Reading, name: str) -> Reading:
    return {key: torch.full_like(value, torch.nan) for key, value in reading.items()}


def frozen(reading: Reading, name: str) -> Reading:
    return dict(MODELS[name][1][2])


@each_model
@pytest.mark.parametrize("fault", [blind, frozen])
def test_it_stands_and_goes_on(name: str, fault: Any) -> None:
    make, readings, bound = MODELS[name]
    policy = make()
    memory, speeds = run(policy, readings[:3])
    assert speeds[-1] > 0

    faulty = [fault(reading, name) for reading in readings[3 : 5 + bound]]
    memory, speeds = run(policy, faulty, memory)
    assert max(speeds[bound - 1 :]) < 1e-9
    assert "0% of the action" in str(policy.explain(memory, row=0))

    _, speeds = run(policy, readings[5 + bound :], memory)
    assert speeds[-1] > 0


@pytest.mark.parametrize(
    ("name", "key"),
    [("reach", "target_position"), ("reach", "ball_1"), ("arm_push", "target")],
)
def test_it_stands_where_only_this_is_gone(name: str, key: str) -> None:
    """Within 0.3 s, and with all else as it was."""
    make, readings, bound = MODELS[name]
    policy = make()
    memory, speeds = run(policy, readings[:3])
    assert speeds[-1] > 0

    gone = [reading | {key: torch.full_like(reading[key], torch.nan)} for reading in readings]
    _, speeds = run(policy, gone[3 : 5 + bound], memory)
    assert max(speeds[bound - 1 :]) < 1e-9


@pytest.mark.parametrize("name", ["nav2d", "pusht"])
def test_the_watchdog_is_an_option(name: str) -> None:
    _, readings, bound = MODELS[name]
    policy = lean(name, watchdog=False)
    memory, _ = run(policy, readings[:3])
    _, speeds = run(policy, [blind(reading, name) for reading in readings[3 : 5 + bound]], memory)
    assert speeds[-1] > 0


def run(
    policy: Policy, readings: list[Reading], memory: dict[str, Tensor] | None = None
) -> tuple[dict[str, Tensor], list[float]]:
    """The memory after these readings, and the speed after each."""
    speeds = []
    for reading in readings:
        _, memory = policy.predict(reading, memory)
        speeds.append(float(memory["a"].norm()))
    assert memory is not None
    return memory, speeds
