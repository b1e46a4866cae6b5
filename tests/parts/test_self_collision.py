import pytest
import torch
from _inputs import normal
from _inputs.arm import HOME, panda_chain, postures

from aicon_torch.errors import OptionError
from aicon_torch.models.arm_push import PANDA
from aicon_torch.parts.hinge import SquaredHinge
from aicon_torch.parts.self_collision import (
    Capsule,
    CapsuleSegments,
    SelfCollision,
    segment_distance,
)

COST = SquaredHinge(margin=0.05, weight=0.05)


def test_segments_are_as_far_apart_as_their_nearest_points():
    first, second = normal(2, 50, 6, seed=2)
    share = torch.linspace(0, 1, 201, dtype=torch.float64).unsqueeze(-1)
    points = [s[:, None, :3] + share * (s[:, None, 3:] - s[:, None, :3]) for s in (first, second)]
    expected = torch.cdist(*points).amin((-1, -2))
    found = segment_distance(first, second)
    torch.testing.assert_close(found, expected, rtol=0, atol=2e-2)
    assert (found <= expected + 1e-9).all()
    torch.testing.assert_close(found, segment_distance(second, first))


def test_parallel_segments_and_points_have_a_distance():
    along = torch.tensor([0.0, 0.0, 0.0, 1.0, 0.0, 0.0], dtype=torch.float64)
    beside = along + torch.tensor([0.5, 0.2, 0.0] * 2, dtype=torch.float64)
    point = torch.tensor([2.0, 0.0, 0.0] * 2, dtype=torch.float64)
    assert abs(segment_distance(along, beside) - 0.2) < 1e-9
    assert abs(segment_distance(along, point) - 1.0) < 1e-9
    assert abs(segment_distance(point, point)) < 1e-8


def test_the_distance_of_segments_has_the_derivative_of_finite_differences():
    first, second = normal(2, 6, seed=4).unbind(0)
    first.requires_grad_()
    torch.autograd.gradcheck(segment_distance, (first, second))


def test_a_capsule_goes_with_its_link():
    capsules = [Capsule(0, (0.1, 0.0, 0.0), (0.2, 0.0, 0.0), 0.05)]
    capsules += [Capsule(link, (0.0, 0.1, 0.0), (0.0, 0.0, 0.3), 0.05) for link in (3, 8)]
    q, chain = postures(2), panda_chain()
    segments = CapsuleSegments(chain, capsules)(q)
    assert segments.shape == (2, 3, 6)
    torch.testing.assert_close(segments[0, 0].tolist(), [0.1, 0.0, 0.0, 0.2, 0.0, 0.0])

    frames = chain.frames(q)
    for row, frame in ((1, frames[:, 2]), (2, frames[:, 7])):
        start = frame[:, :3, 3] + 0.1 * frame[:, :3, 1]
        end = frame[:, :3, 3] + 0.3 * frame[:, :3, 2]
        torch.testing.assert_close(segments[:, row], torch.cat((start, end), dim=-1))


def test_neighbours_are_not_compared():
    capsules = [Capsule(link, (0.0, 0.0, 0.0), (0.0, 0.0, 0.1), 0.05) for link in (0, 2, 3, 8)]
    goal = SelfCollision(capsules, COST)
    pairs = torch.stack((goal.first, goal.second), dim=-1)
    assert pairs.tolist() == [[2, 0], [3, 0], [3, 1], [3, 2]]


def test_the_gap_of_one_pair_is_that_among_all():
    segments, goal = (
        CapsuleSegments(panda_chain(), PANDA.shape.capsules),
        SelfCollision(PANDA.shape.capsules, COST, PANDA.shape.pairs),
    )
    q = HOME.expand(len(goal.first), -1)
    each = torch.arange(len(goal.first))
    assert torch.equal(goal.gap(segments(q), each), goal.gaps(segments(HOME)))


def test_a_folded_arm_costs_and_unfolding_it_helps():
    segments, goal = (
        CapsuleSegments(panda_chain(), PANDA.shape.capsules),
        SelfCollision(PANDA.shape.capsules, COST),
    )
    assert goal(segments(HOME)) == 0
    q = HOME.clone()
    q[3] = -3.0
    q.requires_grad_()
    cost = goal(segments(q))
    (slope,) = torch.autograd.grad(cost, q)
    assert cost > 0
    assert goal(segments((q - 0.02 * slope / slope.norm()).detach())) < cost


@pytest.mark.parametrize("wrong", [{"radius": float("nan")}, {"radius": -1.0}, {"radius": 0.0}])
def test_a_capsule_of_no_size_is_named(wrong):
    capsules = [Capsule(0, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.1)._replace(**wrong)]
    for build in (
        lambda: CapsuleSegments(panda_chain(), capsules),
        lambda: SelfCollision(capsules, COST),
    ):
        with pytest.raises(OptionError, match=r"capsules\[0\]=Capsule.*a radius above 0 m"):
            build()


@pytest.mark.parametrize("link", [-1, 9, 1.5])
def test_a_capsule_is_on_a_link_of_the_chain(link):
    capsules = [Capsule(link, (0.0, 0.0, 0.0), (0.0, 0.0, 0.3), 0.05)]
    with pytest.raises(OptionError, match="expected a link from 0 to 8"):
        CapsuleSegments(panda_chain(), capsules)


@pytest.mark.parametrize("pair", [(9, 0), (-1, 0), (1, 1), (0, 1, 2), (0.7, 1.2)])
def test_a_pair_is_of_two_of_the_capsules(pair):
    capsules = [Capsule(link, (0.0, 0.0, 0.0), (0.0, 0.0, 0.3), 0.05) for link in range(3)]
    with pytest.raises(OptionError, match="pairs: got .* two capsules, from 0 to 2"):
        SelfCollision(capsules, COST, [(2, 0), pair])
