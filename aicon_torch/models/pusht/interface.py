"""Sensors and actuator of the benchmark: where px become metres, and metres px."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from torch import Tensor

from aicon_torch.models.pusht.benchmark import PIXEL, PUSHER_NOISE, WORKSPACE
from aicon_torch.models.pusht.options import Options
from aicon_torch.models.pusht.picture import SEEN
from aicon_torch.models.watched import prompt, watched
from aicon_torch.parts.clock import clock
from aicon_torch.parts.rigid_object import RigidObject, RigidShape
from aicon_torch.parts.servo import PositionTarget, Servo
from aicon_torch.quantities import Actuator, Sensor

BOARD = (-512.0, 1024.0)
"""Where anything can be seen, px: on the board, or a board's width beside it."""

MAX_GAP = 1.5
"""Steps without a reading after which the pusher slows down."""

FASTEST = 1.5
"""How fast the pusher can be for a moment, in speed limits: a controller moves it."""

JUMP_DEVIATIONS = 6.0
"""Change of a reading that noise may bring, in its standard deviations."""

BEND = 3.0 * PIXEL
"""How far a keypoint may be from where the others say that it is, besides its noise, m."""


def sensors(options: Options, body: RigidObject) -> dict[str, Sensor]:
    """What is read, px in m; pusher and object may be out of sight for a while."""
    gap = MAX_GAP if options.watchdog else None
    late = watched(options.dt, options.delay, gap)
    seen = {"optional": True, "scale": PIXEL, "range": BOARD, **late}
    size = 2 * len(body.keypoints)

    # Keypoints that no rigid object can have are no reading.
    shape = RigidShape(body, BEND + JUMP_DEVIATIONS * options.keypoint_noise)
    rigid: dict[str, Any] = {"is_possible": shape} if options.watchdog else {}
    found = {
        "z_pusher": Sensor(2, "m", key="agent_pos", **_moving(options), **seen),
    }

    # The object: its keypoints, or what a network makes of a picture.
    if options.picture is None:
        found["z_keypoints"] = Sensor(size, "m", key="environment_state", **rigid, **seen)
    else:
        found["z_seen"] = Sensor(SEEN, "m, rad, and logarithms", key="seen", optional=True, **late)

    if options.command == "velocity":  # a place is reached, and held, in a time of its own
        found["z_elapsed"] = clock()
    if options.observe_goal:
        scale = (PIXEL, PIXEL, 1.0)
        now = prompt(options.dt, gap)
        found["z_target"] = Sensor(3, "m, m, rad", key="goal_pose", range=BOARD, scale=scale, **now)
    return found


def _moving(options: Options) -> dict[str, Any]:
    """The pusher's place changes while it is driven, and not faster than it can."""
    # In px a second, as it is read: the pusher's speed for a moment, and what noise may add.
    noise = JUMP_DEVIATIONS * PUSHER_NOISE / options.dt
    fastest = (FASTEST * options.max_speed + noise) / PIXEL
    return {"rate_limit": fastest, "driven_by": "a"} if options.watchdog else {}


def actuator(options: Options, servo: Servo) -> Actuator:
    """The pusher's velocity, and what the environment is sent in its place."""
    low, high = WORKSPACE
    fastest = options.max_speed

    # A command beyond the board, or faster than the pusher may be, is never sent.
    bounds = (low, high) if options.command == "position" else (-fastest, fastest)
    return Actuator(
        2,
        "m/s",
        limit=options.max_speed,
        command=_command(options, servo),
        command_range=(bounds[0] / PIXEL, bounds[1] / PIXEL),
    )


def _command(options: Options, servo: Servo) -> Callable[..., Tensor]:
    """A position target in px, or a velocity in px/s."""
    if options.command == "velocity":
        return _velocity_in_pixels
    return _PositionInPixels(PositionTarget(servo if options.compensate_lag else None, WORKSPACE))


@dataclass(frozen=True)
class _PositionInPixels:
    """The position target in px; a class, so that the policy can be pickled."""

    target: PositionTarget

    def __call__(self, a: Tensor, x_pusher: Tensor, v_pusher: Tensor, dt: Tensor) -> Tensor:
        return self.target(a, x_pusher, v_pusher, dt) / PIXEL


def _velocity_in_pixels(a: Tensor) -> Tensor:
    return a / PIXEL
