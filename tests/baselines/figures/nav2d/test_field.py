"""The field that the navigation figure shows is the one that the agent follows."""

import numpy as np
import pytest
from numpy.typing import NDArray

from aicon_baselines.figures.nav2d import NavigationRecording
from aicon_baselines.figures.nav2d.field import clearance, sample
from aicon_envs.nav2d import NavigationMap

CORNERS = [(-0.5, -0.4), (0.6, -0.4), (0.6, 0.3), (-0.5, 0.3)]
BLOCK = NavigationMap("block", [CORNERS], (-2.0, 0.0), (2.0, 0.0))


def test_field_where_the_agent_is_is_what_it_followed(
    followed: tuple[NavigationRecording, list[NDArray[np.float64]]],
) -> None:
    recording, gradients = followed
    assert recording.exploring.any()
    assert not recording.exploring.all()

    for step in range(1, recording.steps, 10):
        field = sample(recording, step, recording.positions[[step]], obstacle="remembered")
        np.testing.assert_allclose(-field.descent[0], gradients[step], rtol=0, atol=1e-9)
        assert field.exploring[0] == recording.exploring[step]


def test_field_does_not_depend_on_its_batch(recording: NavigationRecording) -> None:
    points = recording.positions[[10, 40, -1]] + 0.01
    together = sample(recording, 30, points).descent
    alone = [sample(recording, 30, points[[index]]).descent[0] for index in range(3)]
    np.testing.assert_allclose(together, alone, rtol=0, atol=1e-12)


def test_first_step_has_no_memory_before_it(recording: NavigationRecording) -> None:
    with pytest.raises(ValueError, match="step=0"):
        sample(recording, 0, np.zeros((1, 2)))


def test_clearance_is_the_environments() -> None:
    points = np.array([[-1.0, 0.0], [0.0, 1.0], [1.6, 1.3]])
    diagonal = np.sqrt(0.5)
    expected = [[0.4, -1.0, 0.0], [0.6, 0.0, 1.0], [np.sqrt(2) - 0.1, diagonal, diagonal]]
    np.testing.assert_allclose(clearance(BLOCK, 0.1, points), expected, atol=1e-12)


def test_without_obstacles_all_is_clear() -> None:
    empty = NavigationMap("empty", [], (-2.0, 0.0), (2.0, 0.0))
    distance, *gradient = clearance(empty, 0.1, np.zeros((1, 2)))[0]
    assert distance > 100
    assert gradient == [0.0, 0.0]
