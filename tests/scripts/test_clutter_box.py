"""The box that comes in an arm's way is never driven into it; what touches is what moves."""

import numpy as np
import torch
from _inputs.clutter import beaded_arm
from torch import Tensor

from aicon_torch.parts import Solid, reading_of
from clutter_box import DT, HALFWAY, KEEPS, SPEED, Boxes, Track

STRAIGHT = torch.zeros(1, 3, dtype=torch.float64)


def seen(q: Tensor, box: Solid) -> dict[str, Tensor]:
    return {"q": q, "obstacles": reading_of([box]).expand(1, -1)}


def boxes(y: float, cross: bool) -> tuple[Boxes, dict[str, Tensor]]:
    """A box whose track goes along y, beside an arm that is stretched along x."""
    box = Solid("box", (0.15, 0.15, 0.15), (0.6, y, 0.0))
    track = Track(box, np.array([0.0, 1.0, 0.0]))
    return Boxes(beaded_arm(), [track], cross), seen(STRAIGHT, box)


def test_a_box_that_appears_is_seen_after_the_first_step_and_stays() -> None:
    world, before = boxes(0.5, cross=False)
    before["obstacles"] = before["obstacles"] + torch.eye(1, 16) * 99.0
    for _ in range(3):
        before = world.after(before, STRAIGHT)
    assert before["obstacles"][0, :3].tolist() == [0.6, 0.5, 0.0]


def test_it_goes_to_and_fro() -> None:
    world, before = boxes(0.8, cross=True)
    places = []
    for _ in range(round(4 * HALFWAY / SPEED / DT)):
        before = world.after(before, STRAIGHT)
        places.append(float(before["obstacles"][0, 1]) - 0.8)
    assert np.abs(places).max() <= HALFWAY + SPEED * DT
    assert max(places) > HALFWAY - SPEED * DT
    assert abs(places[-1] + HALFWAY) < 2 * SPEED * DT
    assert world.waited[0] == 0.0


def test_it_stands_still_where_the_arm_is_in_its_way() -> None:
    world, before = boxes(-0.05, cross=True)
    for _ in range(300):
        before = world.after(before, STRAIGHT)
    assert KEEPS <= world.gaps[0] < KEEPS + SPEED * DT
    assert world.waited[0] > 3.0


def test_an_arm_that_moves_into_it_has_touched_it() -> None:
    world, before = boxes(0.3, cross=False)
    for angle in np.arange(0.0, 0.5, 0.02):
        before = world.after(before, torch.tensor([[angle, 0.0, 0.0]], dtype=torch.float64))
    assert world.gaps[0] < 0.0
