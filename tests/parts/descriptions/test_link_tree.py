import numpy as np
import pytest

from aicon_torch.errors import OptionError
from aicon_torch.parts.descriptions import JointDescription, LinkTree, read_urdf

X_AXIS = np.array([1.0, 0.0, 0.0])


def joint(parent: str, child: str, kind: str = "revolute", **more: str) -> JointDescription:
    return JointDescription(f"{parent}_{child}", kind, parent, child, np.eye(4), X_AXIS, **more)


def tree(*joints: JointDescription) -> LinkTree:
    links = {link: None for each in joints for link in (each.parent, each.child)}
    return LinkTree(tuple(links), joints)


def test_a_path_leads_from_base_to_tip() -> None:
    branching = tree(joint("a", "b"), joint("b", "c"), joint("b", "d"), joint("d", "e"))
    assert [each.name for each in branching.path("e")] == ["a_b", "b_d", "d_e"]
    assert [each.name for each in branching.path("d", base="b")] == ["b_d"]


def test_the_end_of_a_robot_that_does_not_branch_is_its_tip() -> None:
    assert [each.name for each in tree(joint("a", "b"), joint("b", "c")).path()] == ["a_b", "b_c"]
    with pytest.raises(OptionError, match="choose tip= among its ends 'b', 'c'"):
        tree(joint("a", "b"), joint("a", "c")).path()


def test_a_robot_that_ends_in_a_gripper_is_asked_where_its_arm_ends() -> None:
    arm = (joint("a", "b"), joint("b", "hand", "fixed"))
    for joints in (
        (*arm, joint("hand", "jaw")._replace(name="jointGripper")),
        (*arm, joint("hand", "left_finger")),
        (joint("a", "b"), joint("b", "gripper_base", "fixed"), joint("gripper_base", "mover")),
    ):
        before, end = joints[-1].parent, joints[-1].child
        with pytest.raises(
            OptionError, match=f"of a gripper: choose tip= among '{before}', '{end}'"
        ):
            tree(*joints).path()
        assert [each.name for each in tree(*joints).path(before) if each.moves] == ["a_b"]

    # A gripper that does not move is part of the arm, and a gripper without an arm a robot.
    assert tree(joint("a", "b"), joint("b", "gripper", "fixed")).path()
    assert tree(joint("gripper", "left_finger")).path()


def test_the_arm_of_unitree_ends_at_its_gripper_only_if_its_user_says_so() -> None:
    robots = pytest.importorskip("_inputs.robots", exc_type=ImportError)
    file = robots.robot_file(robots.ROBOTS["z1"].urdf)
    with pytest.raises(OptionError, match="'jointGripper'.*'gripperStator', 'gripperMover'"):
        read_urdf(file).path()
    assert sum(each.moves for each in read_urdf(file).path("gripperStator")) == 6


@pytest.mark.parametrize(
    ("tip", "base", "message"),
    [
        ("x", None, "tip='x': expected one of 'a', 'b', 'c', 'd'"),
        ("b", "x", "base='x': expected one of 'a', 'b', 'c', 'd'"),
        ("b", "d", "base='d' is not above tip='b': expected one of 'a'"),
        ("d", None, "No joint moves between base='a' and tip='d'"),
    ],
)
def test_links_that_no_chain_joins_are_an_error(tip: str, base: str | None, message: str) -> None:
    branching = tree(joint("a", "b"), joint("b", "c"), joint("a", "d", "fixed"))
    with pytest.raises(OptionError, match=message):
        branching.path(tip, base)


def test_a_joint_that_mimics_another_is_an_error_unless_it_is_fixed_or_beside_the_chain() -> None:
    finger = joint("b", "c", mimics="a_b")
    with pytest.raises(OptionError, match="Joint 'b_c' mimics 'a_b'"):
        tree(joint("a", "b"), finger).path()

    assert tree(joint("a", "b"), finger._replace(kind="fixed")).path()
    assert tree(joint("a", "b"), finger).path(tip="b")


def test_a_joint_of_another_kind_is_an_error_on_the_chain_only() -> None:
    robot = tree(joint("world", "a", "floating"), joint("a", "b"))
    with pytest.raises(OptionError, match="Joint 'world_a' is floating: expected one of"):
        robot.path()
    assert [each.name for each in robot.path(base="a")] == ["a_b"]


def test_links_with_two_roots_or_two_joints_above_them_are_no_robot() -> None:
    with pytest.raises(OptionError, match="one root; this one has 'a', 'c'"):
        tree(joint("a", "b"), joint("c", "d"))
    with pytest.raises(OptionError, match="'c' has two joints: a_c, b_c"):
        tree(joint("a", "b"), joint("a", "c"), joint("b", "c"))


@pytest.mark.parametrize(
    "loop",
    [
        [joint("c", "d"), joint("d", "c")],
        [joint("c", "c")],
        [joint("c", "d"), joint("d", "e"), joint("e", "c"), joint("e", "f")],
    ],
)
def test_joints_in_a_loop_are_an_error_that_names_them(loop: list[JointDescription]) -> None:
    names = ", ".join(f"'{each.name}'" for each in loop if each.child != "f")
    with pytest.raises(OptionError, match="form a loop: expected a tree") as raised:
        tree(joint("a", "b"), *loop)
    assert set(names.split(", ")) == {f"'{n}'" for n in str(raised.value).split("'")[1::2]}


def test_a_chain_of_very_many_joints_is_an_error() -> None:
    long = tree(*(joint(str(number), str(number + 1)) for number in range(1000)))
    with pytest.raises(OptionError, match="There are 1000 joints between .*: expected at most 100"):
        long.path()
    assert len(long.path(tip="100")) == 100


def test_an_error_does_not_list_very_many_names() -> None:
    wide = tree(*(joint("a", f"b{number}") for number in range(1000)))
    with pytest.raises(OptionError, match="'b99' and 900 more"):
        wide.path()
