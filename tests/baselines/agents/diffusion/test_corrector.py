"""A student acts first, and its teacher, who has watched, goes on from where that led."""

from typing import Any

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from torch import Tensor

from aicon_baselines.agents.diffusion.corrector import Corrections, Corrector, actions_of
from aicon_baselines.evaluation.task import Lesson
from aicon_torch import Actuator, Affine, Deterministic, Goal, Policy, Sensor, WorldModel
from aicon_torch.parts import Gripper

WIDEST = 0.1  # m
GRIPPER = Gripper(narrowest=0.0, widest=WIDEST, speed=0.5, first=0.02)


class Always:
    """Sends the same command in every step, and counts the steps of each episode."""

    def __init__(self, value: float) -> None:
        self.value = value

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, *_: Any
    ) -> tuple[Any, Any]:
        count = len(observation["z"])
        steps = np.zeros(count) if state is None else np.where(episode_start, 0, state + 1)
        return np.full((count, 1), self.value), steps


def opener() -> Policy:
    """Opens a gripper, whose opening nothing tells: it follows from what was sent."""

    def wide(x_opening: Tensor) -> Tensor:
        return (WIDEST - x_opening[..., 0]).square() / 2

    model = WorldModel(
        sensors={"z": Sensor(1, "m")},
        actuators={"jaw": GRIPPER.actuator()},
        estimators=[GRIPPER, Deterministic("x", Affine(z=1.0))],
        goals=[Goal("open", wide)],
        dt=0.1,
        dtype=torch.float64,
    )
    return Policy(model)


def run(until: list[int], student: Always, count: int) -> list[tuple[NDArray[Any], Corrections]]:
    """The actions and memories of a few steps."""
    corrector = Corrector(student, opener(), np.array(until))
    steps, memory = [], None
    for step in range(count):
        starts = np.full(len(until), step == 0)
        action, memory = corrector.predict({"z": np.zeros((len(until), 1))}, memory, starts)
        steps.append((action, memory))
    return steps


def test_each_row_is_taught_from_its_own_step_on() -> None:
    steps = run([1, 3, 9], Always(0.7), 5)
    taught = np.stack([memory.taught for _, memory in steps])
    np.testing.assert_array_equal(taught.sum(0), [4, 2, 0])

    for action, memory in steps:
        assert action.shape == (3, 1) and action.dtype == np.float32
        np.testing.assert_allclose(action[~memory.taught], 0.7, rtol=1e-6)
    np.testing.assert_array_equal(steps[-1][1].student, [4, 4, 4])


def test_a_teacher_knows_where_the_student_led() -> None:
    steps = run([2, 4], Always(0.7), 5)
    for _, memory in steps[1:3]:
        np.testing.assert_allclose(memory.teacher["x_opening"][1], 0.7 * WIDEST, rtol=1e-6)

    # So its first command goes on from there, and is none of an episode's beginning.
    first = [steps[2][0][0, 0], steps[4][0][1, 0]]
    np.testing.assert_allclose(first, first[0], rtol=1e-3)
    assert first[0] > 0.7


def test_a_student_is_not_asked_once_the_teacher_acts_in_all_episodes() -> None:
    steps = run([1, 3], Always(0.7), 6)
    np.testing.assert_array_equal(steps[-1][1].student, [2, 2])


@pytest.mark.parametrize("rows", [1, 3])
def test_actions_are_those_that_commands_stand_for(rows: int) -> None:
    turn = torch.tensor([[0.0, -2.0], [0.5, 1.0]], dtype=torch.float64)

    def turned(u: Tensor, x: Tensor) -> Tensor:
        return u @ turn.T + x

    model = WorldModel(
        sensors={"z": Sensor(2, "m")},
        actuators={"u": Actuator(2, "m/s", 1.0, command=turned), "v": Actuator(2, "m/s", 1.0)},
        estimators=[Deterministic("x", Affine(z=1.0, u=1.0, v=1.0))],
        goals=[Goal("there", lambda x: x.square().sum(-1))],
        dt=0.1,
        dtype=torch.float64,
    )
    z = np.random.default_rng(0).normal(size=(rows, 2))
    sent, memory = Policy(model).predict({"z": z})

    actions = actions_of(sent, model, memory)
    for name in ("u", "v"):
        torch.testing.assert_close(actions[name], memory[name], rtol=1e-5, atol=1e-5)


def test_a_lesson_joins_what_is_seen_and_done_and_parts_it_again() -> None:
    parts = {"tip": 3, "jaw": 1}
    lesson = Lesson("", {"observation.state": ("tip", "jaw")}, parts)
    action = {"tip": np.arange(6.0).reshape(2, 3), "jaw": np.array([[7.0], [8.0]])}

    joined = lesson.joined(action)
    np.testing.assert_array_equal(joined, [[0, 1, 2, 7], [3, 4, 5, 8]])
    np.testing.assert_array_equal(lesson.feature("observation.state", action), joined)
    for part, values in lesson.parted(joined).items():
        np.testing.assert_array_equal(values, action[part])

    plain = Lesson("", {}, {"target": 4})
    np.testing.assert_array_equal(plain.parted(plain.joined(joined)), joined)
