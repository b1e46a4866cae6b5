"""What a description of a robot says of its links and joints, whatever its format."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from aicon_torch.errors import OptionError, choices

MOVING = ("revolute", "continuous", "prismatic")
"""The kinds of joints with one degree of freedom."""

OF_A_GRIPPER = ("gripper", "finger", "jaw", "claw", "knuckle", "thumb")
"""Words in the names of joints that open and close a gripper, or of links that carry them."""


class JointDescription(NamedTuple):
    """A joint between two links, with all numbers in float64.

    The child is at T_parent · fixed · M(q), where M turns about the axis, or slides along it.

    Attributes:
        name: Its name.
        kind: "fixed", one of :data:`MOVING`, or another word of the file's, such as "floating".
        parent: The link that it is fixed to.
        child: The link that it moves.
        fixed: ``(4, 4)``, m.
        axis: A unit vector, ``(3,)``, in the frame of the child.
        low: The lowest q, rad or m; −∞ if there is no limit.
        high: The highest q.
        speed: The largest |dq/dt|, rad/s or m/s; ∞ if there is no limit.
        mimics: The joint that this one follows, if any.
    """

    name: str
    kind: str
    parent: str
    child: str
    fixed: NDArray[Any]
    axis: NDArray[Any]
    low: float = -np.inf
    high: float = np.inf
    speed: float = np.inf
    mimics: str | None = None

    @property
    def moves(self) -> bool:
        """Whether it has one degree of freedom."""
        return self.kind in MOVING

    @property
    def is_of_gripper(self) -> bool:
        """Whether it moves a gripper, by its name or that of the link that carries it."""
        names = f"{self.name} {self.parent}".lower()
        return self.moves and any(word in names for word in OF_A_GRIPPER)

    def motion(self, q: float) -> NDArray[Any]:
        """M(q), ``(4, 4)``, for q in rad or m: a turn by Rodrigues' formula, or a shift."""
        motion = np.eye(4)
        if self.kind == "prismatic":
            motion[:3, 3] = q * self.axis
        elif self.moves:
            # R = I + sin q [a]× + (1 − cos q) [a]×².
            cross = np.cross(np.eye(3), self.axis)
            motion[:3, :3] += np.sin(q) * cross + (1.0 - np.cos(q)) * cross @ cross
        return motion


SHOWN = 100
"""An error lists at most so many names."""

MOST_JOINTS = 100
"""In a chain. pytorch-kinematics is recursive, and beyond some 150 joints Python refuses."""


@dataclass(frozen=True)
class LinkTree:
    """The links of a robot and the joints between them.

    Args:
        links: The names of all links.
        joints: Each link has at most one joint above it.

    Raises:
        OptionError: If the joints are no tree over these links, or a name is there twice.
    """

    links: Sequence[str]
    joints: Sequence[JointDescription]
    above: dict[str, JointDescription] = field(init=False, default_factory=dict)
    """The joint whose child a link is; the root has none."""

    def __post_init__(self) -> None:
        _check_unique("links", self.links)
        _check_unique("joints", [joint.name for joint in self.joints])

        # Each joint hangs one link on another, and no link hangs twice.
        links = frozenset(self.links)
        for joint in self.joints:
            for link in (joint.parent, joint.child):
                if link not in links:
                    raise OptionError(f"Joint {joint.name!r} names {link!r}, which is no link.")
            if joint.child in self.above:
                other = self.above[joint.child].name
                raise OptionError(f"Link {joint.child!r} has two joints: {other}, {joint.name}.")
            self.above[joint.child] = joint

        self._check_no_loop()
        roots = [link for link in self.links if link not in self.above]
        if len(roots) != 1:
            raise OptionError(f"A robot has one root; this one has {_shown(roots)}.")

    def _check_no_loop(self) -> None:
        """Check that going up from any link ends.

        Raises:
            OptionError: If it does not; it names the joints of the loop.
        """
        # Up from each link to the root, or to where somebody has climbed from before.
        known: set[str] = set()  # from here it ends
        for link in self.links:
            climbed: dict[str, JointDescription] = {}
            while link in self.above and link not in known:
                if link in climbed:
                    names = [joint.name for joint in climbed.values()]
                    loop = names[list(climbed).index(link) :]
                    raise OptionError(
                        f"The joints {_shown(loop)} form a loop: expected a tree, in "
                        "which every link hangs on the root."
                    )
                climbed[link] = self.above[link]
                link = self.above[link].parent
            known.update(climbed)

    @property
    def root(self) -> str:
        """The link above which there is no joint."""
        return next(link for link in self.links if link not in self.above)

    def only_leaf(self) -> str:
        """The link at the end, where the tree has one end only.

        Raises:
            OptionError: If it branches, or the last joints of an arm are those of a gripper.
        """
        parents = {joint.parent for joint in self.joints}
        leaves = [link for link in self.links if link not in parents]
        if len(leaves) != 1:
            raise OptionError(f"The robot branches: choose tip= among its ends {_shown(leaves)}.")

        # Does the arm end where its gripper does, or before it?
        (leaf,) = leaves
        moving = [joint for joint in self._joints_to(leaf) if joint.moves]
        gripper = [joint for joint in moving if joint.is_of_gripper]
        if gripper and not moving[0].is_of_gripper:
            raise OptionError(
                f"The joint {gripper[0].name!r} seems to be that of a gripper: choose tip= among "
                f"{gripper[0].parent!r}, {leaf!r}, before it or behind it."
            )
        return leaf

    def path(self, tip: str | None = None, base: str | None = None) -> list[JointDescription]:
        """The joints from the base to the tip.

        Args:
            tip: The last link; the end of a robot that does not branch.
            base: The first link; the root.

        Returns:
            At least one of them moves.

        Raises:
            OptionError: If there is no such link, none of them moves, or one of them has more than
                one degree of freedom or follows another joint.
        """
        tip = self.only_leaf() if tip is None else tip
        base = self.root if base is None else base
        for name, link in (("tip", tip), ("base", base)):
            if link not in self.links:
                raise OptionError(f"{name}={link!r}: expected one of {_shown(self.links)}.")

        # The base has to be on the way from the root to the tip.
        from_root = self._joints_to(tip)
        links = [*(joint.parent for joint in from_root), tip]
        if base not in links:
            above_tip = links[-2::-1]
            raise OptionError(
                f"base={base!r} is not above tip={tip!r}: expected one of {_shown(above_tip)}."
            )

        path = from_root[links.index(base) :]
        _check_joints(path, base, tip)
        return path

    def _joints_to(self, link: str) -> list[JointDescription]:
        """The joints from the root to a link."""
        joints: list[JointDescription] = []
        while link in self.above:
            joints.append(self.above[link])
            link = self.above[link].parent
        return joints[::-1]


def _shown(names: Sequence[str]) -> str:
    """The names in an error, the first :data:`SHOWN` of them."""
    more = f" and {len(names) - SHOWN} more" * (len(names) > SHOWN)
    return choices(names[:SHOWN]) + more


def _check_unique(kind: str, names: Sequence[str]) -> None:
    """Check that no name is there twice."""
    counts = Counter(names)
    repeated = [name for name, count in counts.items() if count > 1]
    if repeated:
        raise OptionError(
            f"Several {kind} are called {_shown(repeated)}: expected a name for each."
        )


def _check_joints(path: Sequence[JointDescription], base: str, tip: str) -> None:
    """Check that each joint is fixed, or has a degree of freedom of its own and room to move."""
    if len(path) > MOST_JOINTS:
        raise OptionError(
            f"There are {len(path)} joints between base={base!r} and tip={tip!r}: expected at "
            f"most {MOST_JOINTS}."
        )

    for joint in path:
        if joint.kind not in (*MOVING, "fixed"):
            expected = choices((*MOVING, "fixed"))
            raise OptionError(f"Joint {joint.name!r} is {joint.kind}: expected one of {expected}.")
        if joint.mimics is not None and joint.moves:
            raise OptionError(
                f"Joint {joint.name!r} mimics {joint.mimics!r}: a chain has only joints of their "
                "own. End the chain before it, or make it fixed in the description."
            )
        if joint.moves and not joint.low < joint.high:
            raise OptionError(
                f"Joint {joint.name!r} is {joint.kind} and has no room to move: its limits are "
                f"{joint.low:g} and {joint.high:g} (0 where the description names none). Expected "
                "a lower limit below the upper one, or a joint that is continuous or fixed."
            )

    if not any(joint.moves for joint in path):
        raise OptionError(f"No joint moves between base={base!r} and tip={tip!r}.")
