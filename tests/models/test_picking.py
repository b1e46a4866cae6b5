"""A hand that picks up and places: what it is told, and what that changes."""

from dataclasses import replace
from typing import Any

import pytest
import torch

from aicon_torch.errors import OptionError
from aicon_torch.models.picking import Hand, Options, build_policy

HAND = Hand(time_step=0.1, steps=(0.025,) * 3, widest=0.12, first=0.04, speed=0.3, height=0.012)


def actions(table: float) -> torch.Tensor:
    """What it does in three steps before a block on a table of this height, ``(3, 4)``."""
    policy = build_policy(HAND, Options(table=table))
    high = torch.tensor([0.0, 0.0, table], dtype=torch.float64)
    tip, block, goal = (
        high + torch.tensor(place, dtype=torch.float64)
        for place in ([0.2, 0.1, 0.15], [0.25, 0.0, 0.02], [0.3, 0.1, 0.02])
    )
    memory, done = None, []
    for _ in range(3):
        action, memory = policy.predict({"z_tip": tip, "z_block": block, "z_goal": goal}, memory)
        done.append(torch.cat([action["tip"], action["jaw"]]))
        tip = tip + 0.025 * action["tip"]
    return torch.stack(done)


def test_where_heights_begin_changes_nothing_once_the_table_is_told() -> None:
    torch.testing.assert_close(actions(-0.4), actions(0.0), atol=1e-6, rtol=0.0)


def test_several_blocks_may_be_on_a_table_below_the_origin() -> None:
    assert build_policy(HAND, Options(blocks=2, table=-0.4)).model.paths()


def test_three_paths_lead_from_the_place_to_the_tip() -> None:
    paths = [str(path) for path in build_policy(HAND).model.paths()]
    assert sum(path.startswith("place") and path.endswith("tip") for path in paths) == 3


def test_fingers_turn_to_the_nearest_side_however_far_the_hand_has_turned() -> None:
    edge, quarter = 0.02, 0.02 * torch.pi / 2  # m; the way of a point there in a quarter of a turn
    policy = build_policy(replace(HAND, steps=(0.025, 0.025, 0.025, 0.067 * edge)))
    block, goal = torch.tensor([0.25, 0.0, 0.02, 0.0]), torch.tensor([0.3, 0.1, 0.02])

    memory = None
    for turn in torch.linspace(0.0, 1.5 * quarter, 12):
        tip = torch.tensor([0.2, 0.1, 0.15, turn])
        _, memory = policy.predict({"z_tip": tip, "z_block": block, "z_goal": goal}, memory)
        assert abs(memory["x_rel"][3]) <= 0.65 * quarter  # half of it, and a step


@pytest.mark.parametrize(
    "steps", [(), (0.01,), (0.01, 0.01), (0.01,) * 5, (0.01, 0.0, 0.01), (0.01, 0.01, "a"), 0.01]
)
def test_a_hand_has_a_step_along_each_axis(steps: Any) -> None:
    with pytest.raises(OptionError, match="steps=.*expected 3 lengths above 0 m"):
        replace(HAND, steps=steps)
