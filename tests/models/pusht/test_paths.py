"""The pushing model's graph: two paths over each side."""

from typing import Any

import pytest
from _inputs.pushing import NOTCHED, TRIANGLE, wandering

from aicon_torch import make_policy


def paths_of(**options: Any) -> list[str]:
    return [str(path) for path in make_policy("pusht", **options).model.paths()]


@pytest.mark.parametrize(
    ("keypoints", "sides"),
    [(None, 8), (TRIANGLE, 3), (NOTCHED, 6)],
    ids=["T", "triangle", "notched"],
)
def test_two_paths_lead_over_each_side(keypoints: Any, sides: int) -> None:
    paths = paths_of(keypoints=keypoints)
    assert len(paths) == 2 * sides
    assert set(paths) == {
        f"push → x_obj → {contact}[{side}] → x_pusher → a"
        for contact in ("x_contact", "p_contact")
        for side in range(sides)
    }


@pytest.mark.parametrize(
    ("option", "left"), [("likelihood_path", "x_contact"), ("position_path", "p_contact")]
)
def test_either_half_of_the_paths_can_be_left_out(option: str, left: str) -> None:
    expected = [f"push → x_obj → {left}[{side}] → x_pusher → a" for side in range(8)]
    assert paths_of(**{option: False}) == expected


@pytest.mark.parametrize(("by_row", "count"), [(True, 8), (False, 16)])
def test_by_row_there_is_a_gradient_for_each_contact(by_row: bool, count: int) -> None:
    policy = make_policy("pusht", **{"resolution.by_row": by_row})
    _, memory = policy.predict(wandering(1, 3)[0])
    assert policy.trace(memory).quantities["x_pusher"].gradients.shape == (3, count, 2)
