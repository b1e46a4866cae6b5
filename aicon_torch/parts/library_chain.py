"""What pytorch-kinematics (https://github.com/UM-ARM-Lab/pytorch_kinematics) makes of a chain."""

from collections.abc import Sequence
from typing import Any
from xml.etree import ElementTree

import torch
from torch import Tensor

from aicon_torch.extras import import_extra
from aicon_torch.parts.descriptions import JointDescription


def library_kinematics(path: Sequence[JointDescription], q: Tensor) -> tuple[Tensor, Tensor]:
    """The frames and the Jacobian of a chain, by pytorch-kinematics in float64.

    Args:
        path: The joints from base to tip.
        q: Of those that move, ``(N, n)``, rad or m.

    Returns:
        The n links and the tip, ``(N, n + 1, 4, 4)``, m; the geometric Jacobian ``(N, 6, n)``.

    Raises:
        ModuleNotFoundError: If pytorch-kinematics is missing.
    """
    chain = _load(path)

    # The library has a frame for every link; ours are those that joints move, and the tip.
    moved = [joint.child for joint in path if joint.moves]
    rows = [chain.frame_to_idx[link] for link in (*moved, path[-1].child)]
    frames: Tensor = chain.forward_kinematics_tensor(q)
    jacobian: Tensor = chain.jacobian_tensor(q, all_transforms=frames)
    return frames[rows].movedim(0, 1), jacobian


def _load(path: Sequence[JointDescription]) -> Any:
    """The library's chain, with our numbers.

    Its own reader rounds them to float32 and takes z, not x, for an axis that a URDF does not name.
    It reads no branches, since other joints than those of the chain may be of kinds that it does
    not know.
    """
    library = import_extra("pytorch_kinematics", "robots")
    chain = library.build_chain_from_urdf(_as_urdf(path))

    for joint in path:
        matrix = torch.as_tensor(joint.fixed, dtype=torch.float64)
        loaded = chain.find_joint(joint.name)
        loaded.offset = library.Transform3d(matrix=matrix, dtype=torch.float64)
        loaded.axis = torch.as_tensor(joint.axis, dtype=torch.float64)

    for link in chain.get_links():
        link.offset = None  # an identity, in float32

    base, tip = path[0].parent, path[-1].child
    return library.SerialChain(chain, tip, base, dtype=torch.float64)


def _as_urdf(path: Sequence[JointDescription]) -> bytes:
    """The joints as URDF, without their numbers."""
    root = ElementTree.Element("robot", name="chain")
    for link in (path[0].parent, *(joint.child for joint in path)):
        ElementTree.SubElement(root, "link", name=link)

    for joint in path:
        element = ElementTree.SubElement(root, "joint", name=joint.name, type=joint.kind)
        ElementTree.SubElement(element, "parent", link=joint.parent)
        ElementTree.SubElement(element, "child", link=joint.child)

    return ElementTree.tostring(root)
