"""A chain of pytorch-kinematics (https://github.com/UM-ARM-Lab/pytorch_kinematics), in float64."""

import copy
from collections.abc import Callable, Sequence
from typing import Any
from xml.etree import ElementTree

import torch
from torch import Tensor, nn

from aicon_torch.extras import import_extra
from aicon_torch.parts.descriptions import JointDescription


class LibraryChain(nn.Module):
    """Forward kinematics and Jacobian of pytorch-kinematics.

    The library loads the joints from base to tip, and is then given their numbers: its own reader
    rounds them to float32 and takes z, not x, for an axis that a URDF does not name. It reads no
    branches, since other joints than those of the chain may be of kinds that it does not know.

    Args:
        path: The joints from base to tip.

    Raises:
        ModuleNotFoundError: If pytorch-kinematics is missing.
    """

    def __init__(self, path: Sequence[JointDescription]) -> None:
        super().__init__()
        chain = _load(path)

        moved = [joint.child for joint in path if joint.moves]
        self.rows = [chain.frame_to_idx[link] for link in (*moved, path[-1].child)]

        # The chain of each precision exists before a step that is compiled.
        self.chains = {
            dtype: copy.deepcopy(chain).to(dtype=dtype) for dtype in (torch.float64, torch.float32)
        }

    def forward(self, x_joints: Tensor) -> Tensor:
        """The n links and the tip, ``(*B, n + 1, 4, 4)``, m, at q ``(*B, n)``, rad or m."""
        frames = self._all_frames(x_joints)[self.rows]
        return frames.movedim(0, 1).reshape(*x_joints.shape[:-1], -1, 4, 4)

    def jacobian(self, x_joints: Tensor) -> Tensor:
        """The geometric Jacobian at the tip, ``(*B, 6, n)``, at q ``(*B, n)``."""
        frames = self._all_frames(x_joints)
        chain = self.chains[x_joints.dtype]
        jacobian: Tensor = chain.jacobian_tensor(_flat(x_joints), all_transforms=frames)
        return jacobian.reshape(*x_joints.shape[:-1], *jacobian.shape[1:])

    def _all_frames(self, x_joints: Tensor) -> Tensor:
        """The links of all joints, fixed ones included, ``(links, prod(B), 4, 4)``."""
        # Its own backward would be the first derivative only, and wrong in the second.
        chain = self.chains[x_joints.dtype]
        frames: Tensor = chain.forward_kinematics_tensor(_flat(x_joints), analytical_grad=False)
        return frames

    def _apply(self, fn: Callable[[Tensor], Tensor], recurse: bool = True) -> "LibraryChain":
        """Follow ``module.to(device)``: the library's chains are no modules."""
        super()._apply(fn, recurse)  # type: ignore[no-untyped-call]  # torch's is untyped
        device = fn(torch.zeros(())).device
        for chain in self.chains.values():
            chain.to(device=device)
        return self


def _flat(x_joints: Tensor) -> Tensor:
    """The only shape that the library takes: q as ``(prod(B), n)``."""
    return x_joints.reshape(-1, x_joints.shape[-1])


def _load(path: Sequence[JointDescription]) -> Any:
    """The library's chain, with our numbers."""
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
