"""A student acts first, and its teacher begins where that led."""

from typing import Any

import numpy as np

from aicon_baselines.agents.diffusion.corrector import Corrector
from aicon_baselines.evaluation.task import Lesson

PARTS = {"tip": 3, "jaw": 1}


class Always:
    """Acts alike in every step, and counts the steps of each episode."""

    def __init__(self, value: float) -> None:
        self.value = value

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, *_: Any
    ) -> tuple[Any, Any]:
        count = len(observation["z"])
        steps = np.zeros(count) if state is None else np.where(episode_start, 0, state + 1)
        return {part: np.full((count, size), self.value) for part, size in PARTS.items()}, steps


def test_each_row_is_taught_from_its_own_step_on() -> None:
    corrector = Corrector(Always(-1.0), Always(1.0), np.array([1, 3, 9]))
    memory, taught = None, []
    for step in range(5):
        starts = np.full(3, step == 0)
        action, memory = corrector.predict({"z": np.zeros((3, 1))}, memory, starts)
        assert action["tip"].shape == (3, 3) and action["tip"].dtype == np.float32
        np.testing.assert_array_equal(action["jaw"][:, 0] > 0, memory.taught)
        taught.append(memory.taught.tolist())

    assert [sum(row) for row in zip(*taught, strict=True)] == [4, 2, 0]
    # The teacher has seen nothing before it acts; the student goes on seeing.
    np.testing.assert_array_equal(memory.teacher, [3, 1, 0])
    np.testing.assert_array_equal(memory.student, [4, 4, 4])


def test_a_student_is_not_asked_once_the_teacher_acts_in_all_episodes() -> None:
    corrector = Corrector(Always(-1.0), Always(1.0), np.array([1, 3]))
    memory = None
    for step in range(6):
        starts = np.full(2, step == 0)
        action, memory = corrector.predict({"z": np.zeros((2, 1))}, memory, starts)

    np.testing.assert_array_equal(action["tip"], np.ones((2, 3)))
    np.testing.assert_array_equal(memory.student, [2, 2])
    np.testing.assert_array_equal(memory.teacher, [4, 2])


def test_a_lesson_joins_what_is_seen_and_done_and_parts_it_again() -> None:
    lesson = Lesson("", {"observation.state": ("tip", "jaw")}, PARTS)
    action = {"tip": np.arange(6.0).reshape(2, 3), "jaw": np.array([[7.0], [8.0]])}

    joined = lesson.joined(action)
    np.testing.assert_array_equal(joined, [[0, 1, 2, 7], [3, 4, 5, 8]])
    np.testing.assert_array_equal(lesson.feature("observation.state", action), joined)
    for part, values in lesson.parted(joined).items():
        np.testing.assert_array_equal(values, action[part])

    plain = Lesson("", {}, {"target": 4})
    np.testing.assert_array_equal(plain.parted(plain.joined(joined)), joined)
