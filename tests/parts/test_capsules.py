import re

import pytest
import torch
from _inputs.robots import ROBOTS, Physics, mujoco_model, random_postures, robot_file

from aicon_torch.errors import OptionError
from aicon_torch.parts.capsules import Capsules
from aicon_torch.parts.chain import Chain
from aicon_torch.parts.hinge import SquaredHinge
from aicon_torch.parts.robot import Robot
from aicon_torch.parts.self_collision import CapsuleSegments, SelfCollision

pytest.importorskip("pytorch_kinematics")
pytest.importorskip("trimesh")
mujoco = pytest.importorskip("mujoco")

COST = SquaredHinge(margin=0.05, weight=1.0)


def link(name: str, shape: str = "", at: str = "0 0 0.2") -> str:
    origin = f'<origin xyz="{at}"/>'
    collision = f"<collision>{origin}<geometry>{shape}</geometry></collision>" * bool(shape)
    return f'<link name="{name}">{collision}</link>'


def joint(parent: str, child: str, kind: str = "revolute", more: str = "") -> str:
    return (
        f'<joint name="{child}_joint" type="{kind}">'
        f'<parent link="{parent}"/><child link="{child}"/>{more}'
        '<origin xyz="0 0 0.4"/><axis xyz="0 1 0"/>'
        '<limit lower="-3" upper="3" velocity="1" effort="1"/></joint>'
    )


ROD = '<cylinder radius="0.03" length="0.3"/>'
ARM = "".join(
    (
        '<robot name="arm">',
        link("base", ROD) + link("one", ROD) + link("two", ROD) + link("three", ROD),
        link("hand", '<sphere radius="0.05"/>', "0 0 0") + link("finger", ROD),
        joint("base", "one") + joint("one", "two") + joint("two", "three"),
        joint("three", "hand", "fixed"),
        joint("hand", "finger", "prismatic", '<mimic joint="one_joint"/>'),
        "</robot>",
    )
)


def test_each_link_goes_with_the_joint_that_moves_it() -> None:
    shape = Capsules.from_urdf(ARM, tip="hand")
    assert shape.links == ("base", "one", "two", "three", "hand", "finger")
    assert [capsule.link for capsule in shape.capsules] == [0, 1, 2, 3, 3, 3]


def test_a_sphere_is_kept_and_a_link_beside_the_chain_has_its_place() -> None:
    shape = Capsules.from_urdf(ARM, tip="hand")
    hand, finger = shape.capsules[4:]
    assert hand.radius == 0.05 and hand.start == hand.end == pytest.approx((0.0, 0.0, 0.4))
    assert finger.start[2] + finger.end[2] == pytest.approx(2 * (0.4 + 0.4 + 0.2))


def test_neighbours_and_what_moves_together_are_not_compared() -> None:
    shape = Capsules.from_urdf(ARM, tip="hand")
    named = {(shape.links[i], shape.links[j]) for i, j in shape.pairs}
    assert {("base", "two"), ("base", "three"), ("one", "hand")} <= named
    assert not named & {("base", "one"), ("three", "hand"), ("hand", "finger")}


def test_what_the_srdf_disables_is_not_compared() -> None:
    srdf = '<robot name="arm"><disable_collisions link1="two" link2="base"/></robot>'
    all_of_them = Capsules.from_urdf(ARM, tip="hand")
    fewer = Capsules.from_urdf(ARM, srdf=srdf, tip="hand")
    gone = set(all_of_them.pairs) - set(fewer.pairs)
    assert {(fewer.links[i], fewer.links[j]) for i, j in gone} == {("base", "two")}


def test_pairs_that_always_overlap_or_never_meet_are_not_compared() -> None:
    always = ARM.replace(link("base", ROD), link("base", '<sphere radius="2"/>'))
    shape = Capsules.from_urdf(always, tip="hand")
    assert all("base" not in (shape.links[i], shape.links[j]) for i, j in shape.pairs)

    never = ARM.replace(link("base", ROD), link("base", ROD, at="0 0 -9"))
    shape = Capsules.from_urdf(never, tip="hand")
    assert all("base" not in (shape.links[i], shape.links[j]) for i, j in shape.pairs)


def test_a_folded_arm_touches_itself_and_a_stretched_one_does_not() -> None:
    chain, shape = Chain.from_urdf(ARM, tip="hand"), Capsules.from_urdf(ARM, tip="hand")
    segments = CapsuleSegments(chain, shape.capsules)
    goal = SelfCollision(shape.capsules, COST, pairs=shape.pairs)

    q = torch.tensor([[0.0, 0.0, 0.0], [0.0, 2.9, 0.0]], dtype=torch.float64)
    stretched, folded = goal(segments(q)).tolist()
    assert stretched == 0.0 < folded


def test_more_pairs_than_can_be_compared_are_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("aicon_torch.parts.capsules.MOST_PAIRS", 3)
    with pytest.raises(OptionError, match="6 capsules make . pairs that may meet: expected at mo"):
        Capsules.from_urdf(ARM, tip="hand")


@pytest.mark.parametrize(
    "name", ["panda", *(pytest.param(name, marks=pytest.mark.slow) for name in ("ur5", "xarm7"))]
)
def test_what_touches_in_the_physics_touches_as_capsules(name: str) -> None:
    """MuJoCo compares the convex hulls of the same meshes."""
    robot = ROBOTS[name]
    urdf, tip = robot_file(robot.urdf), robot.tip
    chain = Chain.from_urdf(urdf, tip=tip)
    shape = Capsules.from_urdf(urdf, srdf=robot_file(str(robot.srdf)), tip=tip, per_link=1)
    overlaps = SelfCollision(shape.capsules, COST, pairs=shape.pairs)

    physics = Physics(mujoco_model(urdf, keep_collisions=True), chain.names)
    compared = {frozenset((shape.links[i], shape.links[j])) for i, j in shape.pairs}
    touching = 0
    for q in random_postures(chain, 300):
        found = overlaps.distances(CapsuleSegments(chain, shape.capsules)(q)) < 0.0
        physics.move(q)
        mujoco.mj_collision(physics.model, physics.data)

        for contact in physics.data.contact:
            bodies = physics.model.geom_bodyid[contact.geom]
            names = frozenset(physics.model.body(body).name for body in bodies)
            if names in compared:
                touching += 1
                assert found.any(), names

    assert touching > 0


def test_a_robot_without_collision_geometry_has_no_shape_and_says_so() -> None:
    bare = re.sub(r"<collision>.*?</collision>", "", ARM, flags=re.DOTALL)
    with pytest.warns(UserWarning, match="no collision geometry"):
        robot = Robot.from_urdf(bare, tip="hand")
    assert robot.shape is None
