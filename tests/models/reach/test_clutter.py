"""An arm among objects: it touches none, and comes around what is in the way."""

import pytest
import torch
from _inputs.clutter import POST, START, TARGET, beaded_arm, policy
from _inputs.reaching import planar_arm, reach

from aicon_torch import make_policy
from aicon_torch.errors import OptionError
from aicon_torch.models.reach.options import PRESETS
from aicon_torch.parts import Solid, Solids, SquaredHinge, reading_of
from aicon_torch.safety import SafetyBounds, nearest_safe


def gaps(way: torch.Tensor) -> torch.Tensor:
    """The least distance to the post on the way."""
    robot = beaded_arm()
    assert robot.shape is not None
    solids = Solids(robot.chain, robot.shape.capsules, 1, SquaredHinge(0.01, 1.0))
    return solids.distances(way, reading_of([POST]).expand(len(way), -1)).amin(-1)


def test_an_arm_comes_around_a_post_that_holds_it_up_without_the_escape() -> None:
    seen = {"target_position": TARGET, "obstacles": reading_of([POST], 2)}
    ways = {}
    for escapes in (True, False):
        ways[escapes], _ = reach(policy(escapes), START, seconds=30, **seen)
        assert gaps(ways[escapes]).amin() > 0.0

    chain = beaded_arm().chain
    nearest = {}
    for escapes, way in ways.items():
        nearest[escapes] = (chain(way)[:, :3, 3] - TARGET).norm(dim=-1).amin()
    assert nearest[True] < 0.01
    assert nearest[False] > 0.1


def test_a_batch_of_scenes_is_the_scenes_one_by_one() -> None:
    target = TARGET.expand(3, -1)
    scenes = [[POST], [POST, Solid("sphere", (0.1,), (0.0, 0.5, 0.0))], []]
    objects = torch.stack([reading_of(scene, 2) for scene in scenes])
    together, _ = reach(
        policy(), START.expand(3, -1), seconds=1, target_position=target, obstacles=objects
    )
    for row, seen in enumerate(objects):
        alone, _ = reach(policy(), START, seconds=1, target_position=TARGET, obstacles=seen)
        torch.testing.assert_close(alone, together[:, row])


def test_the_compiled_step_is_the_readable_one() -> None:
    robot = {"robot": beaded_arm(), "obstacles": 2}
    readable = make_policy("reach", preset="clutter", **robot)
    compiled, q = policy(), START
    state = other = None
    for _ in range(8):
        seen = {"q": q, "target_position": TARGET, "obstacles": reading_of([POST], 2)}
        action, state = readable.predict(seen, state)
        same, other = compiled.predict(seen, other)
        torch.testing.assert_close(same, action, rtol=0.0, atol=1e-9)
        q = q + 0.02 * action


@pytest.mark.parametrize("spoilt", ["nothing", "turned", "flat", "unknown"])
def test_an_arm_rests_while_an_object_cannot_be(spoilt: str) -> None:
    objects = reading_of([POST], 2)
    rotation, half_lengths, kind = slice(3, 12), slice(12, 15), 15
    match spoilt:
        case "nothing":
            objects[rotation] = 0.0
        case "turned":
            objects[rotation] *= 2.0
        case "flat":
            objects[half_lengths] *= -1.0
        case "unknown":
            objects[kind] = 7.0
    way, _ = reach(policy(), START, seconds=1, target_position=TARGET, obstacles=objects)
    torch.testing.assert_close(way[-1], START)


def test_a_robot_has_its_tip_already() -> None:
    with pytest.raises(OptionError, match="tip='hand': expected None, since the robot is no URDF"):
        make_policy("reach", robot=planar_arm(), tip="hand")


def test_objects_are_kept_from_a_shape() -> None:
    with pytest.raises(OptionError, match="obstacles=1: expected 0, since the robot has no shape"):
        make_policy("reach", robot=planar_arm(shape=False), obstacles=1)


def test_joints_that_nothing_is_near_go_on_where_the_others_are_wedged() -> None:
    # The upper arm of a Fetch between boards: bounds that nearly oppose each other, so that an
    # action comes near to them in many sweeps only. None of them concerns the last joint.
    slopes = torch.tensor(
        [
            [-0.11, -0.32, -0.07, -0.04, 0.0, 0.0],
            [0.0, 0.40, 0.30, -0.03, -0.01, 0.0],
            [0.0, 0.36, -0.02, 0.0, 0.0, 0.0],
            [0.33, -0.07, 0.03, 0.0, 0.0, 0.0],
        ],
        dtype=torch.float64,
    )
    bounds = torch.tensor([0.0, 0.0, -0.001, -0.001], dtype=torch.float64)
    fastest = torch.full((6,), 1.5, dtype=torch.float64)
    wanted = torch.tensor([0.0, 1.5, -1.2, 1.5, -0.6, 1.1], dtype=torch.float64)

    sweeps = PRESETS["clutter"]["dampers.sweeps"]
    found = nearest_safe(wanted, SafetyBounds(slopes, bounds, -fastest, fastest), sweeps).action
    assert float(found[5]) == pytest.approx(1.1, rel=1e-3)
    assert bool((slopes @ found > bounds - 1e-3).all())
