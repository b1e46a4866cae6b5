"""Sensors and actuator of the benchmark: where px become metres, and metres px."""

from collections.abc import Callable

from torch import Tensor

from aicon_torch.models.pusht.benchmark import PIXEL, WORKSPACE
from aicon_torch.models.pusht.options import Options
from aicon_torch.parts.rigid_object import RigidObject
from aicon_torch.parts.servo import PositionTarget, Servo
from aicon_torch.quantities import Actuator, Sensor


def sensors(options: Options, body: RigidObject) -> dict[str, Sensor]:
    """What is read, px in m; pusher and object may be out of sight for a while."""
    size = 2 * len(body.keypoints)
    found = {
        "z_pusher": Sensor(2, "m", key="agent_pos", optional=True, scale=PIXEL),
        "z_keypoints": Sensor(size, "m", key="environment_state", optional=True, scale=PIXEL),
    }

    if options.observe_goal:
        scale = (PIXEL, PIXEL, 1.0)
        found["z_target"] = Sensor(3, "m, m, rad", key="goal_pose", scale=scale)
    return found


def actuator(options: Options, servo: Servo) -> Actuator:
    """The pusher's velocity, and what the environment is sent in its place."""
    return Actuator(2, "m/s", limit=options.max_speed, command=_command(options, servo))


def _command(options: Options, servo: Servo) -> Callable[..., Tensor]:
    """A position target in px, or a velocity in px/s."""
    target = PositionTarget(servo if options.compensate_lag else None, WORKSPACE)

    def position_in_pixels(a: Tensor, x_pusher: Tensor, v_pusher: Tensor, dt: float) -> Tensor:
        return target(a, x_pusher, v_pusher, dt) / PIXEL

    def velocity_in_pixels(a: Tensor) -> Tensor:
        return a / PIXEL

    return position_in_pixels if options.command == "position" else velocity_in_pixels
