"""The steps of LeRobot's processors: a shield, and from a pose of the tip to joints."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

pytest.importorskip("lerobot")
pytest.importorskip("mujoco")
pytest.importorskip("lerobot_robot_aicon")

from _so101 import AboveTable, arm, joints, to_action
from lerobot.configs.types import PipelineFeatureType
from lerobot.processor import RobotProcessorPipeline
from lerobot.processor.converters import (
    robot_action_observation_to_transition,
    transition_to_robot_action,
)
from scipy.spatial.transform import Rotation

from lerobot_robot_aicon import AiconSimulated, AiconSimulatedConfig, EndEffectorStep, ShieldStep

pytestmark = pytest.mark.slow

AXIS = (0.0, 0.0, 1.0)
CONVERTERS: dict[str, Any] = {
    "to_transition": robot_action_observation_to_transition,
    "to_output": transition_to_robot_action,
}


@pytest.fixture(scope="module")
def processor() -> Any:
    steps = [
        EndEffectorStep(urdf="so101", orientation="axis", axis=AXIS),
        ShieldStep(urdf="so101", table=0.0),
    ]
    return RobotProcessorPipeline(steps=steps, **CONVERTERS)


@pytest.fixture
def robot() -> AiconSimulated:
    robot = AiconSimulated(AiconSimulatedConfig(seed=3))
    robot.connect()
    return robot


def tip_of(posture: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Place of the tip ``(3,)``, m, and its rotation ``(3, 3)``."""
    pose = arm().chain.forward(torch.tensor(posture))
    return pose[:3, 3].numpy(), pose[:3, :3].numpy()


def test_the_tip_comes_to_the_pose_that_is_sent(processor: Any, robot: AiconSimulated) -> None:
    place, turned = tip_of(np.radians([30.0, -40.0, 50.0, 30.0, 10.0]))
    vector = Rotation.from_matrix(turned).as_rotvec()
    names = ("x", "y", "z", "wx", "wy", "wz")
    pose = dict(zip((f"ee.{name}" for name in names), [*place, *vector], strict=True))

    processor.reset()
    for _ in range(120):
        observation = robot.get_observation()
        robot.send_action(processor((pose, observation)))

    reached, as_it_is = tip_of(joints(robot.get_observation()))
    assert reached == pytest.approx(place, abs=0.003)
    assert as_it_is @ AXIS == pytest.approx(turned @ AXIS, abs=0.03)


def test_a_pose_below_the_table_is_not_gone_to(processor: Any, robot: AiconSimulated) -> None:
    above_table, least = AboveTable(), np.inf
    pose = {"ee.x": 0.2, "ee.y": 0.0, "ee.z": -0.05, "ee.wx": np.pi, "ee.wy": 0.0, "ee.wz": 0.0}

    processor.reset()
    for _ in range(120):
        observation = robot.get_observation()
        robot.send_action(processor((pose, observation)))
        least = min(least, float(above_table(joints(observation))))
    assert 0 < least < 0.03


def test_a_saved_processor_is_the_same(
    processor: Any, robot: AiconSimulated, tmp_path: Path
) -> None:
    processor.save_pretrained(tmp_path)
    file = next(tmp_path.glob("*.json")).name
    loaded = RobotProcessorPipeline.from_pretrained(tmp_path, file, **CONVERTERS)

    pose = {f"ee.{name}": 0.1 for name in ("x", "y", "z", "wx", "wy", "wz", "gripper_pos")}
    observation = robot.get_observation()
    processor.reset()
    for expected in ({"gripper.pos"}, {*to_action(np.zeros(5)), "gripper.pos"}):
        sent = processor((pose, observation))
        assert sent.keys() == expected
        assert sent["gripper.pos"] == 0.1
        assert loaded((pose, observation)) == sent


def test_an_opening_that_is_not_finite_is_not_sent(processor: Any, robot: AiconSimulated) -> None:
    pose = {f"ee.{name}": 0.1 for name in ("x", "y", "z", "wx", "wy", "wz")}
    processor.reset()
    for _ in range(2):
        sent = processor(({**pose, "ee.gripper_pos": np.nan}, robot.get_observation()))
    assert sent.keys() == to_action(np.zeros(5)).keys()


def test_a_pose_lacks_a_component(processor: Any, robot: AiconSimulated) -> None:
    with pytest.raises(ValueError, match=r"no ee\.wz; expected ee\.x"):
        pose = {f"ee.{name}": 0.1 for name in ("x", "y", "z", "wx", "wy")}
        processor((pose, robot.get_observation()))


def test_features_become_those_of_the_motors(processor: Any) -> None:
    features = {PipelineFeatureType.ACTION: {"ee.x": None}, PipelineFeatureType.OBSERVATION: {}}
    expected = {*to_action(np.zeros(5)), "gripper.pos"}
    transformed = processor.transform_features(features)
    assert set(transformed[PipelineFeatureType.ACTION]) == expected
