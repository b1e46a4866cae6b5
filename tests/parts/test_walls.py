"""Walls of a map: gaps to their faces, also in corners and within the wall."""

import pickle
from typing import Any

import numpy as np
import pytest
import torch
from torch import Tensor

from aicon_torch import OptionError
from aicon_torch.parts import Walls

U = ["#####", "#   #", "### #", "#   #", "#####"]


def at(*numbers: float) -> Tensor:
    return torch.tensor(numbers, dtype=torch.float64)


@pytest.mark.parametrize(
    ("place", "gaps"),
    [
        ((-1.0, 1.0), (0.4, 0.4, 0.4)),  # west, north and south of the free cell
        ((-1.3, 0.8), (0.1, 0.2, 0.6)),  # an inner corner: both walls count
        ((-1.55, 1.0), (-0.15,)),  # within the wall
        ((1.0, 0.0), (0.4, 0.4)),  # in the doorway, whose walls end above and below
    ],
)
def test_each_face_has_its_gap(place: tuple[float, float], gaps: tuple[float, ...]) -> None:
    walls = Walls.from_grid(U, radius=0.1)
    nearest = walls.gaps(at(*place)).sort().values[: len(gaps)]
    torch.testing.assert_close(nearest, at(*gaps))


def test_a_straight_wall_is_one_face_and_cells_have_a_length() -> None:
    assert len(Walls.from_grid(U).faces) == 8
    twice = Walls.from_grid(U, cell=2.0)
    torch.testing.assert_close(twice.gaps(at(-2.0, 2.0)), 2.0 * Walls.from_grid(U).gaps(at(-1, 1)))


def test_in_an_inner_corner_the_cost_falls_along_the_diagonal() -> None:
    place = at(-1.35, 0.65).requires_grad_()
    cost = Walls.from_grid(U, radius=0.1).collision_likelihood(0.04)(place)
    (gradient,) = torch.autograd.grad(cost, place)
    torch.testing.assert_close(gradient[0], gradient[1])
    assert gradient[0] < 0


def test_a_batch_is_its_rows() -> None:
    walls = Walls.from_grid(U)
    places = torch.rand(4, 3, 2, dtype=torch.float64)
    torch.testing.assert_close(walls.gaps(places)[2, 1], walls.gaps(places[2, 1]))


def test_a_face_without_length_is_refused() -> None:
    with pytest.raises(OptionError, match=r"\(1.0, 2.0, 1.0, 2.0\): expected two points apart"):
        Walls(((1.0, 2.0, 1.0, 2.0),))
    with pytest.raises(OptionError, match="two points apart"):
        Walls.from_grid(U, cell=0.0)


@pytest.mark.parametrize(("rows", "what"), [(["##", "#"], "one length"), (["  "], "one or more")])
def test_what_is_no_map_is_refused(rows: list[str], what: str) -> None:
    with pytest.raises(OptionError, match=what):
        Walls.from_grid(rows)


def test_faces_may_come_in_an_array() -> None:
    faces = Walls.from_grid(U).faces
    for given in (np.array(faces), torch.tensor(faces), [list(face) for face in faces]):
        assert Walls(given) == Walls(faces)
        assert hash(Walls(given)) == hash(Walls(faces))


@pytest.mark.parametrize("faces", [None, "abcd", [None], ["abcd"], [(0.0, 0.0, 1.0)]], ids=str)
def test_what_is_no_face_is_refused(faces: Any) -> None:
    with pytest.raises(OptionError, match=r"faces=.*expected one or more \(x, y, x, y\)"):
        Walls(faces)


def test_their_cost_is_kept_in_a_pickle() -> None:
    cost = Walls.from_grid(U).collision_likelihood(0.1)
    assert pickle.loads(pickle.dumps(cost)) == cost
