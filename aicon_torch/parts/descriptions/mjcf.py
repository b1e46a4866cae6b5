"""Reads links and joints from MJCF, which MuJoCo compiles, in float64."""

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aicon_torch.errors import OptionError
from aicon_torch.extras import import_extra
from aicon_torch.parts.descriptions.attributes import LARGEST_NUMBER
from aicon_torch.parts.descriptions.compilation import compile_mjcf
from aicon_torch.parts.descriptions.link_tree import JointDescription, LinkTree


def read_mjcf(source: str | Path) -> LinkTree:
    """The bodies, sites and joints of a model of MuJoCo's.

    Before the link of a body come those of its joints, named ``"body/0"``, ``"body/1"``. The values
    of the joints are MuJoCo's: the model stands as it is drawn at ``qpos0``. MJCF knows no speeds.

    Args:
        source: A file, or the text of one.

    Raises:
        FileNotFoundError: If there is no such file.
        OptionError: If MuJoCo does not accept it, or only with too much time or memory, or a number
            is none; it names the element.
        ModuleNotFoundError: If MuJoCo is missing.
    """
    model, spec = compile_mjcf(source)
    mujoco = import_extra("mujoco", "robots")
    for joint in spec.joints:
        _check_range(mujoco, joint)

    reader = _Reader(mujoco, model)
    reader.check_numbers()
    return reader.tree()


def _check_range(mujoco: Any, joint: Any) -> None:
    """Check the limits of a joint, which MuJoCo leaves out where they are none.

    Raises:
        OptionError: If the lower one is not below the upper one. MJCF takes (0, 0) for no limits.
    """
    low, high = joint.range
    is_free = joint.limited == mujoco.mjtLimited.mjLIMITED_FALSE or (low, high) == (0.0, 0.0)
    if not is_free and not low < high:
        raise OptionError(
            f"Joint {joint.name!r}: <joint range='{low:g} {high:g}'>: expected lower below upper."
        )


def _check_finite(owner: str, *arrays: NDArray[Any]) -> None:
    """Check positions, quaternions and axes.

    Raises:
        OptionError: If a number is not finite, or too large.
    """
    for array in arrays:
        if not (np.abs(array) <= LARGEST_NUMBER).all():
            found = " ".join(f"{number:g}" for number in array)
            raise OptionError(f"{owner}: {found}: expected numbers within ±{LARGEST_NUMBER:.0e}.")


class _Reader:
    """From a compiled model to a tree.

    Args:
        mujoco: The module.
        model: An ``MjModel``.
    """

    def __init__(self, mujoco: Any, model: Any) -> None:
        self.mujoco, self.model = mujoco, model
        self.links: list[str] = [self._body_name(0)]
        self.joints: list[JointDescription] = []

    def check_numbers(self) -> None:
        """Check that everything is somewhere.

        Raises:
            OptionError: If a number is not finite, or too large; it names the body, joint or site.
        """
        model = self.model
        for number in range(model.nbody):
            owner = f"Body {self._body_name(number)!r}"
            _check_finite(owner, model.body_pos[number], model.body_quat[number])

        for number in range(model.njnt):
            owner, address = f"Joint {model.joint(number).name!r}", model.jnt_qposadr[number]
            drawn_at = model.qpos0[address : address + 1]
            _check_finite(owner, model.jnt_pos[number], model.jnt_axis[number], drawn_at)

        for number in range(model.nsite):
            owner = f"Site {model.site(number).name!r}"
            _check_finite(owner, model.site_pos[number], model.site_quat[number])

    def tree(self) -> LinkTree:
        """The links of all bodies and sites."""
        for index in range(1, self.model.nbody):
            self._add_body(index)

        # Sites are links that do not move, so that one can be the tip.
        for index in range(self.model.nsite):
            site = self.model.site(index)
            if site.name and site.name not in self.links:
                body = self._body_name(self.model.site_bodyid[index])
                self._add_fixed(body, site.name, self._transform(site.pos, site.quat))

        return LinkTree(self.links, self.joints)

    def _add_body(self, index: int) -> None:
        """Add a body after its joints, which follow each other."""
        body, name = self.model.body(index), self._body_name(index)
        parent = self._body_name(self.model.body_parentid[index])
        fixed = self._transform(body.pos, body.quat)

        first = self.model.body_jntadr[index]
        for number in range(self.model.body_jntnum[index]):
            # A joint turns about its own position, which is not the origin of the body.
            position = np.eye(4)
            position[:3, 3] = self.model.jnt_pos[first + number]

            link = f"{name}/{number}"
            self._add_joint(first + number, parent, link, fixed @ position)
            parent, fixed = link, np.linalg.inv(position)

        self._add_fixed(parent, name, fixed)

    def _add_joint(self, index: int, parent: str, child: str, fixed: NDArray[Any]) -> None:
        """Add a joint, which stands at ``qpos0`` where the model is drawn."""
        model = self.model
        kind = self._kind(index)
        limited = bool(model.jnt_limited[index]) and kind in ("revolute", "prismatic")
        low, high = model.jnt_range[index].tolist() if limited else (-np.inf, np.inf)

        name = model.joint(index).name or f"joint {index}"
        joint = JointDescription(
            name=name,
            kind=kind,
            parent=parent,
            child=child,
            fixed=fixed,
            axis=model.jnt_axis[index].copy(),
            low=low,
            high=high,
            mimics=self._leader(index),
        )

        # Drawn at qpos0, the link is M(qpos0) beyond where it is at zero.
        drawn_at = float(model.qpos0[model.jnt_qposadr[index]])
        from_zero = np.linalg.inv(joint.motion(drawn_at))
        self.joints.append(joint._replace(fixed=fixed @ from_zero))
        self.links.append(child)

    def _add_fixed(self, parent: str, child: str, fixed: NDArray[Any]) -> None:
        """Add a link that does not move in the frame of its parent."""
        name, x_axis = f"to {child}", np.array([1.0, 0.0, 0.0])
        self.joints.append(JointDescription(name, "fixed", parent, child, fixed, x_axis))
        self.links.append(child)

    def _kind(self, index: int) -> str:
        """The kind of a joint, in the words of URDF."""
        joint_type = self.mujoco.mjtJoint(int(self.model.jnt_type[index]))
        kinds = {
            self.mujoco.mjtJoint.mjJNT_HINGE: "revolute",
            self.mujoco.mjtJoint.mjJNT_SLIDE: "prismatic",
            self.mujoco.mjtJoint.mjJNT_BALL: "ball",
            self.mujoco.mjtJoint.mjJNT_FREE: "floating",
        }
        return kinds[joint_type]

    def _leader(self, index: int) -> str | None:
        """The joint that an equality constraint makes this one follow, if any."""
        model = self.model

        # The first joint of such a constraint follows the second one, or a constant.
        couples = model.eq_type == int(self.mujoco.mjtEq.mjEQ_JOINT)
        active = couples & (model.eq_active0 == 1) & (model.eq_obj1id == index)
        if not active.any():
            return None

        leader = int(model.eq_obj2id[active.argmax()])
        return str(model.joint(leader).name) if leader >= 0 else "a constant"

    def _body_name(self, index: int) -> str:
        """The name of a body; its number where it has none."""
        return self.model.body(index).name or f"body {index}"

    def _transform(self, position: NDArray[Any], quaternion: NDArray[Any]) -> NDArray[Any]:
        """The transform ``(4, 4)`` of a position (m) and a quaternion (w, x, y, z)."""
        rotation = np.zeros(9)
        self.mujoco.mju_quat2Mat(rotation, quaternion)

        transform = np.eye(4)
        transform[:3, :3] = rotation.reshape(3, 3)
        transform[:3, 3] = position
        return transform
