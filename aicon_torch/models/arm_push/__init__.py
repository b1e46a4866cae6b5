"""The model "arm_push": an arm pushes an object to a pose, by a camera."""

from aicon_torch.models.arm_push.graph import build, camera_perception, world_model
from aicon_torch.models.arm_push.options import PRESETS, CameraOptions, Options
from aicon_torch.models.arm_push.perception import CameraPerception
from aicon_torch.models.arm_push.robot import PANDA, PushingRobot
from aicon_torch.models.arm_push.scene import end_effector

__all__ = [
    "PANDA",
    "PRESETS",
    "CameraOptions",
    "CameraPerception",
    "Options",
    "PushingRobot",
    "build",
    "camera_perception",
    "end_effector",
    "world_model",
]
