"""Robots of example-robot-data, and what MuJoCo says of them."""

import importlib.metadata
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np
import pytest
import torch
from torch import Tensor

from aicon_torch.parts.chain import Chain

mujoco = pytest.importorskip("mujoco")


class RobotFiles(NamedTuple):
    """The files of a robot, within those of the package, and its last link."""

    urdf: str
    tip: str
    srdf: str | None = None


ROBOTS = {
    "panda": RobotFiles(
        "panda_description/urdf/panda.urdf",
        "panda_hand_tcp",
        "panda_description/srdf/panda.srdf",
    ),
    "ur5": RobotFiles(
        "ur_description/urdf/ur5_robot.urdf", "tool0", "ur_description/srdf/ur5.srdf"
    ),
    "kinova": RobotFiles("kinova_description/robots/kinova.urdf", "j2s6s200_end_effector"),
    "xarm7": RobotFiles(
        "xarm_description/urdf/xarm7.urdf", "link7", "xarm_description/srdf/xarm7.srdf"
    ),
    "so101": RobotFiles("so_arm_description/urdf/so101.urdf", "gripper_frame_link"),
    "z1": RobotFiles("z1_description/urdf/z1.urdf", "gripperStator"),
    "tiago": RobotFiles("tiago_description/robots/tiago.urdf", "arm_tool_link"),
}


def robot_file(name: str) -> Path:
    """A file of example-robot-data, such as ``"panda_description/urdf/panda.urdf"``."""
    for file in importlib.metadata.files("example-robot-data") or []:
        if str(file).endswith(f"robots/{name}"):
            return Path(str(file.locate())).resolve()
    raise FileNotFoundError(name)


def read_chain(name: str) -> Chain:
    robot = ROBOTS[name]
    return Chain.from_urdf(robot_file(robot.urdf), tip=robot.tip)


def mujoco_model(urdf: Path, keep_collisions: bool = False) -> Any:
    """The links and joints of a URDF; with its meshes if they are STL in one folder."""
    root = ElementTree.parse(urdf).getroot()
    removed = ["visual", "inertial"] + ["collision"] * (not keep_collisions)
    for link in root.findall("link"):
        for tag in removed:
            for element in link.findall(tag):
                link.remove(element)

    options = {"fusestatic": "false", "boundmass": "1", "boundinertia": "1"}
    for mesh in root.iter("mesh"):
        inside = mesh.attrib["filename"].partition("/robots/")[2]
        file = robot_file(inside)
        mesh.set("filename", file.name)
        options["meshdir"] = str(file.parent)

    compiler = ElementTree.SubElement(root, "mujoco")
    ElementTree.SubElement(compiler, "compiler", options)
    return mujoco.MjModel.from_xml_string(ElementTree.tostring(root, encoding="unicode"))


def random_postures(chain: Chain, count: int, seed: int = 0) -> Tensor:
    """Within the limits, ``(count, n)``; without limits within ±π."""
    low = torch.where(chain.low.isfinite(), chain.low, -torch.pi)
    high = torch.where(chain.high.isfinite(), chain.high, torch.pi)
    generator = torch.Generator().manual_seed(seed)
    share = torch.rand(count, len(low), generator=generator, dtype=torch.float64)
    return low + share * (high - low)


class Physics:
    """MuJoCo at some values of a chain's joints."""

    def __init__(self, model: Any, names: tuple[str, ...]) -> None:
        self.model, self.data = model, mujoco.MjData(model)
        joints = [model.joint(name).id for name in names]
        self.positions = model.jnt_qposadr[joints]
        self.velocities = model.jnt_dofadr[joints]
        self.bodies = model.jnt_bodyid[joints]

    def move(self, q: Tensor) -> None:
        self.data.qpos[self.positions] = q.numpy()
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)

    def frame(self, body: int | str) -> Tensor:
        view = self.data.body(body)
        transform = np.eye(4)
        transform[:3, :3] = view.xmat.reshape(3, 3)
        transform[:3, 3] = view.xpos
        return torch.tensor(transform)

    def frames(self, tip: str) -> Tensor:
        """``(n + 1, 4, 4)``, as :meth:`Chain.frames` has them."""
        bodies = [*self.bodies.tolist(), tip]
        return torch.stack([self.frame(body) for body in bodies])

    def jacobian(self, tip: str) -> Tensor:
        """``(6, n)``, as :meth:`Chain.jacobian` has it."""
        jacobian = np.zeros((6, self.model.nv))
        body = self.model.body(tip).id
        mujoco.mj_jacBody(self.model, self.data, jacobian[:3], jacobian[3:], body)
        return torch.tensor(jacobian[:, self.velocities])
