"""Objects of any shape and place: distances, their gradients, and what a robot keeps off."""

import math

import pytest
import torch
from torch import Tensor

from aicon_torch.errors import OptionError
from aicon_torch.parts import Capsule, Chain, Solid, Solids, SquaredHinge, reading_of
from aicon_torch.parts.solids import can_be_solids, distance_of_point

TURNED = (0.8, 0.3, -0.5, 0.1)
SOLIDS = {
    "box": Solid("box", (0.4, 0.2, 0.1), (0.3, -0.2, 0.5), TURNED),
    "cylinder": Solid("cylinder", (0.3, 0.1), (0.3, -0.2, 0.5), TURNED),
    "capsule": Solid("capsule", (0.3, 0.1), (0.3, -0.2, 0.5), TURNED),
    "sphere": Solid("sphere", (0.2,), (0.3, -0.2, 0.5)),
}


def points(count: int) -> Tensor:
    generator = torch.Generator().manual_seed(1)
    middle = torch.tensor([0.3, -0.2, 0.5], dtype=torch.float64)
    return middle + 0.4 * torch.randn(count, 3, generator=generator, dtype=torch.float64)


def surface(solid: Solid) -> Tensor:
    """Many points on the surface, placed by the description alone, ``(m, 3)``."""
    generator = torch.Generator().manual_seed(2)
    count = 200_000
    u = torch.rand(count, 3, generator=generator, dtype=torch.float64) * 2 - 1
    directions = torch.randn(count, 3, generator=generator, dtype=torch.float64)
    directions = directions / directions.norm(dim=-1, keepdim=True)

    if solid.kind == "box":
        local = u.clone()
        side = torch.where(torch.arange(count) % 2 == 0, 1.0, -1.0).to(local)
        local[torch.arange(count), torch.arange(count) % 3] = side
        local = local * torch.tensor(solid.size, dtype=torch.float64) / 2
    elif solid.kind == "cylinder":
        length, radius = solid.size
        angle, share = math.pi * u[:, 0], torch.where(u[:, 2] > 0, 1.0, u[:, 1].abs().sqrt())
        height = torch.where(u[:, 2] > 0, u[:, 1], torch.sign(u[:, 2] + 0.5)) * length / 2
        local = torch.stack((radius * share * angle.cos(), radius * share * angle.sin(), height), 1)
    elif solid.kind == "capsule":
        length, radius = solid.size
        axis = torch.zeros(count, 3, dtype=torch.float64)
        axis[:, 2] = (u[:, 0] * length).clamp(-length / 2, length / 2)
        side = directions * torch.tensor([1.0, 1.0, 0.0], dtype=torch.float64)
        side = side / side.norm(dim=-1, keepdim=True)
        ends = torch.sign(directions[:, 2:]) * torch.tensor([0.0, 0.0, length / 2])
        is_side = (torch.arange(count) % 2 == 0).unsqueeze(-1)
        local = torch.where(is_side, axis + radius * side, ends + radius * directions)
    else:
        local = solid.size[0] * directions

    w, x, y, z = solid.orientation
    scale = math.sqrt(w * w + x * x + y * y + z * z)
    vector = torch.tensor([x, y, z], dtype=torch.float64) / scale
    twice = 2 * torch.linalg.cross(vector.expand_as(local), local)
    turned = local + w / scale * twice + torch.linalg.cross(vector.expand_as(local), twice)
    return turned + torch.tensor(solid.position, dtype=torch.float64)


@pytest.mark.parametrize("kind", SOLIDS)
def test_a_distance_is_that_to_the_nearest_point_of_the_surface(kind: str) -> None:
    here, solid = points(40), SOLIDS[kind]
    nearest = torch.cdist(here, surface(solid)).amin(-1)
    distance = distance_of_point(here, solid.numbers())

    outside = distance > 0
    assert outside.any()
    torch.testing.assert_close(distance[outside], nearest[outside], atol=3e-3, rtol=0.0)


@pytest.mark.parametrize("kind", SOLIDS)
def test_the_gradient_of_a_distance_is_of_length_one_and_leads_away(kind: str) -> None:
    here = points(40).requires_grad_()
    numbers = SOLIDS[kind].numbers()
    distance = distance_of_point(here, numbers)
    (gradient,) = torch.autograd.grad(distance.sum(), here)
    torch.testing.assert_close(gradient.norm(dim=-1), torch.ones(40, dtype=torch.float64))

    moved = distance_of_point(here.detach() + 1e-6 * gradient, numbers)
    torch.testing.assert_close(
        moved - distance.detach(), torch.full_like(moved, 1e-6), rtol=1e-3, atol=0.0
    )


def test_inside_a_distance_is_negative() -> None:
    for solid in SOLIDS.values():
        middle = torch.tensor(solid.position, dtype=torch.float64)
        assert distance_of_point(middle, solid.numbers()) < -0.04


def chain() -> Chain:
    """Two joints that turn about z and y."""
    fixed = torch.eye(4).tolist()
    second = [[1, 0, 0, 0.3], [0, 0, -1, 0], [0, 1, 0, 0.2], [0, 0, 0, 1]]
    return Chain([fixed, second], [[1, 0, 0, 0.4], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])


BODY = {
    "spheres": [
        Capsule(1, (0.1, 0, 0), (0.1, 0, 0), 0.05),
        Capsule(2, (0.3, 0, 0), (0.3, 0, 0), 0.1),
    ],
    "capsules": [Capsule(0, (0, 0, 0), (0, 0, 1), 0.1), Capsule(2, (0, 0, 0), (0.4, 0, 0), 0.05)],
}


@pytest.mark.parametrize("body", BODY)
def test_one_gap_is_the_one_of_that_number_among_all(body: str) -> None:
    solids = Solids(chain(), BODY[body], len(SOLIDS), SquaredHinge(0.01, 1.0))
    q = torch.randn(5, 2, generator=torch.Generator().manual_seed(0), dtype=torch.float64)
    objects = reading_of(list(SOLIDS.values())).expand(5, -1)

    gaps = solids.gaps(q, objects)
    count = gaps.shape[-1]
    each = torch.arange(count).unsqueeze(-1).expand(-1, 5)
    one_by_one = solids.gap(q.expand(count, -1, -1), objects.expand(count, -1, -1), each)
    torch.testing.assert_close(one_by_one, gaps.mT)


@pytest.mark.parametrize("body", BODY)
def test_the_slope_of_one_gap_is_that_of_all(body: str) -> None:
    solids = Solids(chain(), BODY[body], len(SOLIDS), SquaredHinge(0.01, 1.0))
    q = torch.tensor([0.3, -0.4], dtype=torch.float64, requires_grad=True)
    objects = reading_of(list(SOLIDS.values()))

    gaps = solids.gaps(q, objects)
    count = len(gaps)
    copies = q.detach().expand(count, -1).clone().requires_grad_()
    one_by_one = solids.gap(copies, objects.expand(count, -1), torch.arange(count))
    (slopes,) = torch.autograd.grad(one_by_one.sum(), copies)
    for slope, gap in zip(slopes, gaps, strict=True):
        (expected,) = torch.autograd.grad(gap, q, retain_graph=True)
        torch.testing.assert_close(slope, expected)


def test_a_capsule_is_as_far_as_the_nearest_of_many_spheres_on_its_axis() -> None:
    start, end = torch.zeros(3), torch.tensor([0.4, 0.0, 0.0])
    on_axis = [(start + share * (end - start)).tolist() for share in torch.linspace(0, 1, 400)]
    spheres = [Capsule(2, tuple(p), tuple(p), 0.05) for p in on_axis]
    hinge, q = SquaredHinge(0.01, 1.0), torch.tensor([0.3, -0.4], dtype=torch.float64)

    for solid in SOLIDS.values():
        objects = reading_of([solid])
        capsule = Solids(chain(), BODY["capsules"], 1, hinge).distances(q, objects)
        nearest = Solids(chain(), spheres, 1, hinge).distances(q, objects).amin()
        torch.testing.assert_close(capsule, nearest.reshape(1), atol=1e-3, rtol=0.0)


def test_in_single_precision_it_is_as_near_but_for_a_thousandth_of_a_millimetre() -> None:
    generator = torch.Generator().manual_seed(0)
    q = torch.randn(2000, 2, generator=generator, dtype=torch.float64)
    for solid in SOLIDS.values():
        objects = reading_of([solid]).expand(2000, -1)
        double = Solids(chain(), BODY["capsules"], 1, SquaredHinge(0.01, 1.0))
        single = Solids(chain().float(), BODY["capsules"], 1, SquaredHinge(0.01, 1.0)).float()
        found = single.distances(q.float(), objects.float()).double()
        torch.testing.assert_close(found, double.distances(q, objects), atol=1e-5, rtol=0.0)


def test_objects_that_there_are_not_are_far_away() -> None:
    solids = Solids(chain(), BODY["spheres"], 3, SquaredHinge(0.01, 1.0))
    q = torch.zeros(2, dtype=torch.float64)
    distances = solids.distances(q, reading_of([SOLIDS["box"]], 3)).reshape(3, -1)
    assert (distances[1:] > 50).all()
    assert float(solids(q, reading_of([], 3))) == 0.0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("cone", (0.1,), (0.0, 0.0, 0.0)), "'box', 'cylinder'"),
        (("sphere", (0.1, 0.2), (0.0, 0.0, 0.0)), "expected 1 numbers above 0 m for a sphere"),
        (("box", (0.1, 0.2, 0.0), (0.0, 0.0, 0.0)), "expected 3 numbers"),
        (("sphere", 0.1, (0.0, 0.0, 0.0)), "size=0.1: expected 1 numbers"),
        (("sphere", ("a",), (0.0, 0.0, 0.0)), "size=.*: expected 1 numbers"),
        (("sphere", (0.1,), (0.0, 0.0)), "position=.*expected 3 finite numbers"),
        (("sphere", (0.1,), (0.0, 0.0, float("nan"))), "position=.*expected 3 finite numbers"),
        (("sphere", (0.1,), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)), "orientation=.*not zero"),
    ],
)
def test_a_wrong_object_is_refused(arguments: tuple[object, ...], message: str) -> None:
    with pytest.raises(OptionError, match=message):
        Solid(*arguments)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("given", "count"), [(SOLIDS["box"], None), (["box"], 3), ([], None), ([SOLIDS["box"]], 2.0)]
)
def test_what_is_no_list_of_objects_is_refused(given: object, count: object) -> None:
    with pytest.raises(OptionError, match="solids"):
        reading_of(given, count)  # type: ignore[arg-type]


def test_what_is_read_of_objects_can_be() -> None:
    assert can_be_solids(reading_of(list(SOLIDS.values()), 9))
    assert can_be_solids(reading_of(list(SOLIDS.values()), 9).float())


@pytest.mark.parametrize("kind", ["cylinder", "capsule", "sphere"])
@pytest.mark.parametrize("axis", [12, 13, 14])
def test_what_is_round_is_as_wide_as_deep(kind: str, axis: int) -> None:
    reading = SOLIDS[kind].numbers()
    reading[axis] /= 2
    is_only_shorter = axis == 14 and kind != "sphere"
    assert can_be_solids(reading) == is_only_shorter


def test_more_objects_than_a_policy_reads_are_refused() -> None:
    with pytest.raises(OptionError, match="at most 1"):
        reading_of([SOLIDS["box"], SOLIDS["sphere"]], 1)
