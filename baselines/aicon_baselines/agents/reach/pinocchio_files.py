"""The robot as files that libraries about Pinocchio read: the shapes and joints of the scene."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from aicon_envs.reach import Robot
from aicon_envs.reach.urdf import read_description

if TYPE_CHECKING:
    from aicon_baselines.agents.reach.kinematics import Kinematics

LinkPair = tuple[str, str]


@contextmanager
def description_files(robot: Robot) -> Iterator[Path]:
    """A folder with `robot.urdf` and its meshes, in which only the joints to the tip move."""
    described = read_description(robot)
    with TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "robot.urdf").write_text(described.text)
        for file, content in described.assets.items():
            (folder / file).write_bytes(content)
        yield folder


def pairs_of_links(kinematics: "Kinematics") -> set[LinkPair]:
    """The pairs of links whose contacts count, both ways around."""
    model = kinematics.model
    found: set[LinkPair] = set()
    for (first,), (second,) in kinematics.pairs_that_can_meet():
        names = [model.body(model.geom_bodyid[geom]).name for geom in (first, second)]
        found |= {(names[0], names[1]), (names[1], names[0])}
    return found


def write_pairs(folder: Path, pairs: list[LinkPair]) -> None:
    """Write the pairs of links whose shapes are compared, as placo reads them."""
    (folder / "collisions.json").write_text(json.dumps(pairs))
