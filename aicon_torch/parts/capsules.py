"""The capsules of a robot, fitted to the collision geometry of its description."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from aicon_torch.errors import OptionError
from aicon_torch.parts.capsule_fit import Segment, around_cylinder
from aicon_torch.parts.chain import Chain
from aicon_torch.parts.descriptions import JointDescription, LinkTree, parse_xml, read_urdf
from aicon_torch.parts.descriptions.collision import CollisionGeometry, read_collision_geometry
from aicon_torch.parts.hinge import SquaredHinge
from aicon_torch.parts.kept_fits import fitted_once
from aicon_torch.parts.self_collision import Capsule, CapsuleSegments, SelfCollision, distant_pairs
from aicon_torch.quantities import as_count

Pair = tuple[int, int]

SAMPLES = 4096
"""Random postures in which it is seen which capsules meet."""

REACH = 0.05
"""Capsules that were never nearer than this in any of them, m, are taken never to meet."""

MOST_PAIRS = 20_000
"""So many are compared; a robot of 60 capsules has some 1,500."""

APART = 0.01
"""Links that were never further apart than this in any of them, m, are taken for neighbours."""


@dataclass(frozen=True)
class Capsules:
    """The shape of a robot as capsules, and which of them can meet.

    Attributes:
        capsules: For :class:`CapsuleSegments` and :class:`SelfCollision`.
        links: The link of the description that each belongs to.
        pairs: The numbers of the capsules that can meet, for ``SelfCollision(pairs=)``.

    Example:
        >>> shape = Capsules.from_urdf("ur5.urdf", srdf="ur5.srdf", tip="tool0")
        >>> segments = CapsuleSegments(chain, shape.capsules)
        >>> goal = SelfCollision(shape.capsules, SquaredHinge(0.05, 1.0), pairs=shape.pairs)
    """

    capsules: tuple[Capsule, ...]
    links: tuple[str, ...]
    pairs: tuple[Pair, ...]

    @classmethod
    def from_urdf(
        cls,
        source: str | Path,
        srdf: str | Path | None = None,
        tip: str | None = None,
        base: str | None = None,
        per_link: int = 4,
    ) -> "Capsules":
        """Capsules that enclose the collision geometry of all links.

        Spheres and capsules stay what they are, cylinders become the smallest capsule about them,
        and boxes and meshes of one link together as few as fit well. Links that do not belong to
        the chain go with the one that they hang on, their joints at 0 or at the limit next to it.

        Left out are the pairs that the SRDF disables, those of links between which there is only
        one joint, and, as seen in random postures within the limits, those that always overlap,
        whose links never come apart, or that never come near each other.

        Args:
            source: The URDF, a file next to its meshes, or its text.
            srdf: A file, or the text of one, whose ``<disable_collisions>`` are read.
            tip: That of the chain, as for :meth:`Chain.from_urdf`.
            base: That of the chain.
            per_link: At most so many capsules for the boxes and meshes of a link.

        Raises:
            FileNotFoundError: If a file or mesh is missing.
            ModuleNotFoundError: If an extra package is missing.
            OptionError: See :meth:`Chain.from_urdf`; also if a shape or mesh is not what it may be,
                or ``per_link`` no whole number above 0.
        """
        if as_count(per_link) < 1:
            raise OptionError(f"per_link={per_link!r}: expected a whole number > 0.")
        tree = read_urdf(source)
        path = tree.path(tip, base)
        disabled = set() if srdf is None else _disabled_pairs(srdf)

        # Capsules for each link, in the frame of the chain's link that it goes with.
        places = _places(tree, path)
        capsules: list[Capsule] = []
        links: list[str] = []
        for link, geometry in read_collision_geometry(source).items():
            number, transform = places[link]
            for segment in _fit(geometry, per_link):
                capsules.append(_placed(segment, number, transform))
                links.append(link)

        # Pairs of them that may come near each other, as far as the joints' ranges let them.
        chain = Chain.from_path(path)
        apart = distant_pairs(capsules, free_links=1)  # neighbours touch at their joint
        candidates = [(j, i) for i, j in apart if frozenset((links[i], links[j])) not in disabled]
        if len(candidates) > MOST_PAIRS:
            raise OptionError(
                f"The robot's {len(capsules)} capsules make {len(candidates)} pairs that may meet: "
                f"expected at most {MOST_PAIRS}. Disable some with srdf=."
            )
        pairs = _that_can_meet(chain, capsules, links, candidates)
        return cls(tuple(capsules), tuple(links), tuple(pairs))


def _disabled_pairs(srdf: str | Path) -> set[frozenset[str]]:
    """The pairs of links that an SRDF says not to compare."""
    root = parse_xml(srdf, root_tag="robot")
    found: set[frozenset[str]] = set()
    for element in root.iter("disable_collisions"):
        found.add(frozenset((str(element.get("link1")), str(element.get("link2")))))
    return found


def _places(
    tree: LinkTree, path: Sequence[JointDescription]
) -> Mapping[str, tuple[int, NDArray[Any]]]:
    """For each link the number of the chain's link that it goes with, and its place there."""
    # The links of the chain: the base, and what each joint moves.
    numbers: dict[str, int] = {}
    frames = {0: path[0].parent}
    for joint in path:
        if joint.moves:
            numbers[joint.child] = len(frames)
            frames[len(frames)] = joint.child

    # Another link goes with the nearest of them above it, at rest.
    places: dict[str, tuple[int, NDArray[Any]]] = {}
    for link in tree.links:
        above = link
        while above not in numbers and above in tree.above:
            above = tree.above[above].parent

        # T_frame⁻¹ T_link: the link as the link of the chain sees it.
        number = numbers.get(above, 0)
        of_frame, of_link = _at_rest(tree, frames[number]), _at_rest(tree, link)
        places[link] = number, np.linalg.solve(of_frame, of_link)
    return places


def _at_rest(tree: LinkTree, link: str) -> NDArray[Any]:
    """The transform of a link from the root, all joints at 0 or at the limit next to it."""
    transform = np.eye(4)
    while link in tree.above:
        joint = tree.above[link]
        rest = float(np.clip(0.0, joint.low, joint.high))
        transform = joint.fixed @ joint.motion(rest) @ transform
        link = joint.parent
    return transform


def _fit(geometry: CollisionGeometry, per_link: int) -> list[Segment]:
    """Capsules about the geometry of a link, in its frame."""
    segments: list[Segment] = []
    for cylinder in geometry.cylinders:
        end = np.array([0.0, 0.0, cylinder.length / 2.0])
        segment = Segment(-end, end, cylinder.radius)

        # With round ends it is a capsule; a flat one needs the smallest capsule around it.
        if not cylinder.is_round:
            segment = around_cylinder(cylinder.length, cylinder.radius)
        segments.append(segment.moved(cylinder.pose))

    if geometry.triangles:
        segments += fitted_once(geometry.triangles, per_link)
    return segments


def _placed(segment: Segment, number: int, transform: NDArray[Any]) -> Capsule:
    """A segment in the frame of a link as a capsule on the chain."""
    moved = segment.moved(transform)
    (x, y, z), (u, v, w) = moved.start.tolist(), moved.end.tolist()
    return Capsule(number, (x, y, z), (u, v, w), segment.radius)


def _that_can_meet(
    chain: Chain, capsules: Sequence[Capsule], links: Sequence[str], candidates: Sequence[Pair]
) -> list[Pair]:
    """The pairs that do not always overlap, of links that come apart and near each other."""
    if not candidates:
        return []

    segments = CapsuleSegments(chain, capsules)

    # Its distances are of use here, not its cost.
    compared = SelfCollision(capsules, SquaredHinge(margin=1.0, weight=1.0), candidates)
    of_links = _numbered([frozenset((links[i], links[j])) for i, j in candidates])
    least = torch.full((len(candidates),), torch.inf, dtype=torch.float64)
    largest, largest_of_links = -least, -least

    # In parts, since many pairs take much memory.
    for q in torch.split(chain.postures(SAMPLES), 256):
        distances = compared.distances(segments(q))
        least = torch.minimum(least, distances.amin(0))
        largest = torch.maximum(largest, distances.amax(0))

        # How near two links come: the least over all pairs of their capsules.
        nearest = torch.full_like(distances, torch.inf)
        nearest.scatter_reduce_(1, of_links.expand_as(distances), distances, "amin")
        largest_of_links = torch.maximum(largest_of_links, nearest[:, of_links].amax(0))

    can_meet = (largest > 0.0) & (largest_of_links > APART) & (least < REACH)
    return [pair for pair, keep in zip(candidates, can_meet.tolist(), strict=True) if keep]


def _numbered(names: Sequence[frozenset[str]]) -> Tensor:
    """The same number for the same names, ``(len(names),)``."""
    numbers = {name: number for number, name in enumerate(dict.fromkeys(names))}
    return torch.tensor([numbers[name] for name in names])
