"""Pushing with an arm, as a Gymnasium environment."""

import math
from typing import Any, Literal, cast, get_args

import gymnasium as gym
import numpy as np
import shapely
from gymnasium import spaces
from gymnasium.error import ResetNeeded
from numpy.typing import ArrayLike, NDArray

from aicon_envs.panda_push import scene
from aicon_envs.panda_push.description import describe
from aicon_envs.panda_push.objects import Prism, resolve_object
from aicon_envs.panda_push.rendering import Camera
from aicon_envs.panda_push.simulation import CONTROL_STEP, FloatArray, Simulation

ObsType = Literal["rgbd", "pose"]
Observation = dict[str, NDArray[Any]]

SUCCESS_DISTANCE = 0.01
"""Largest distance between object and target for success, m."""

SUCCESS_ANGLE = math.radians(5.0)
"""Largest difference of their angles, rad."""

AREA = ((0.48, 0.60), (-0.15, 0.15))
"""Where starts and targets of the object's centroid are drawn, x and y, m: all its sides can be reached there."""

CONTACT_HEIGHT = 0.02
"""Height of the tip at the start, m: half the objects' thickness."""

_OPTIONS = ("object_pose", "target_pose", "tip", "yaw")
_LARGE = 1e3


class PandaPushEnv(gym.Env[Observation, NDArray[np.float32]]):
    """A Panda pushes an object on a table into a target pose with a stick.

    The physics are MuJoCo's at 1 kHz, the description of the arm that of `example-robot-data`. All coordinates are in
    the frame of the robot's base, m: x toward the table, z up from its top.

    ## Action
    `Box((7,), float32)`: velocity of each joint, rad/s, up to 2.175 (joints 1 to 4) and 2.61 (5 to 7); 100 Hz.

    ## Observation
    | key | space | meaning |
    |---|---|---|
    | `q`, `dq` | (7,) | joint angles (rad) and velocities (rad/s) of the encoders |
    | `ft` | (6,) | force (N) and torque (Nm) at the flange in its frame, noisy, the weight of the tool in it |
    | `target` | (3,) | target pose of the object: x, y, angle |
    | `rgb` | (120, 160, 3) uint8 | the camera in the hand, 20 Hz |
    | `depth` | (120, 160) float32 | distance along its optical axis, m, noisy |
    | `image_age` | (1,) | age of the image, s; where it does not grow by 0.01 the image is new |

    With `obs_type="pose"` there is `object_pose` (3,) instead of the last three: the truth.

    ## Reward
    -√(|Δ|² + (r Δθ)²) per step, m, with r = 0.07 m.

    ## Start
    Poses of object and target are drawn from `area` with any angle, the tip upright beside the object. The options
    `object_pose`, `target_pose` (3,), `tip` (2,) and `yaw` of `reset` set them.

    ## End
    Terminates at success, within 1 cm and 5°, and when the object falls off the table. The registered limit is 18,000
    steps, 180 s.

    ## Info
    `object_pose`, `target_pose` (3,); `position` (2,): the tip; `tip` (3,); `distance`, m; `angle`, rad; `is_success`;
    `collision`: whether the robot touched itself or the table; `fallen`; `limit_margin`, rad, the joint nearest to its
    limits; `self_distance`, m, the smallest gap between capsules of the robot that can meet.

    ## Arguments
    `obs_type`; `render_mode`: None or "rgb_array"; `render_camera`: "outside" or "hand"; `object`: a name, see
    `aicon_envs.panda_push.objects.names()`, a `Prism` or an outline, m; `mass` (0.5 kg) and `friction` (0.35) of the
    object; `image_delay`: s; `depth_noise` (3 mm), `force_noise` (0.1 N; torques a fiftieth), `joint_noise` (1e-4 rad):
    standard deviations; `area`: bounds in x and y within which start and target are drawn, m; `kick_time`: when the
    object is pushed from outside, s, or None; `kick_force`: with how much for 0.2 s, N.

    ## Version history
    v0: first version.

    Example:
        >>> import gymnasium as gym
        >>> import aicon_envs
        >>> env = gym.make("aicon/PandaPush-v0", obs_type="pose")
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 20}

    def __init__(
        self,
        obs_type: ObsType = "rgbd",
        render_mode: str | None = None,
        render_camera: str = "outside",
        object: str | Prism | ArrayLike = "T",
        mass: float = 0.5,
        friction: float = 0.35,
        image_delay: float = 0.0,
        depth_noise: float = 0.003,
        force_noise: float = 0.1,
        joint_noise: float = 1e-4,
        area: tuple[tuple[float, float], tuple[float, float]] = AREA,
        kick_time: float | None = None,
        kick_force: float = 3.0,
        width: int = 160,
        height: int = 120,
        render_width: int = 640,
        render_height: int = 480,
    ) -> None:
        """Create the environment; see the class for the arguments.

        Raises:
            ValueError: If a value is not valid; the message names it and says what is.
        """
        if obs_type not in get_args(ObsType):
            raise ValueError(
                f"obs_type must be one of {', '.join(get_args(ObsType))}, got {obs_type!r}"
            )
        if render_mode not in (None, "rgb_array"):
            raise ValueError(f'render_mode must be None or "rgb_array", got {render_mode!r}')
        if render_camera not in ("outside", "hand"):
            raise ValueError(f'render_camera must be "outside" or "hand", got {render_camera!r}')
        for name, value in (("mass", mass), ("friction", friction)):
            if not value > 0:
                raise ValueError(f"{name} must be positive, got {value!r}")
        self.object = resolve_object(object)
        self.obs_type, self.render_mode, self._render_camera = obs_type, render_mode, render_camera
        self._size, self._shown = (width, height), (render_width, render_height)
        self._delay = round(image_delay / CONTROL_STEP)
        self._noises = (depth_noise, force_noise, joint_noise)
        self._area = area
        self._kick_step = None if kick_time is None else round(kick_time / CONTROL_STEP)
        self._kick_force = kick_force
        self._simulation = Simulation(scene.build(self.object, mass, friction))
        self._cameras: dict[str, Camera] = {}
        self._target: FloatArray | None = None
        self.observation_space = self._observation_space()
        speed = np.array(scene.SPEED_LIMIT, dtype=np.float32)
        self.action_space = cast(
            "spaces.Space[NDArray[np.float32]]", spaces.Box(-speed, speed, dtype=np.float32)
        )

    def description(self) -> dict[str, Any]:
        """The robot as plain data, see :func:`aicon_envs.panda_push.description.describe`."""
        return describe(self._simulation.model, *self._size)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start an episode; see the class for the options."""
        super().reset(seed=seed)
        options = {key: value for key, value in (options or {}).items() if value is not None}
        unknown = sorted(map(str, set(options) - set(_OPTIONS)))
        if unknown:
            raise ValueError(
                f"unknown option {', '.join(unknown)}; valid options are {', '.join(_OPTIONS)}"
            )
        pose, target = self._draw_pose(), self._draw_pose()
        pose = np.asarray(options.get("object_pose", pose), dtype=np.float64)
        self._target = np.asarray(options.get("target_pose", target), dtype=np.float64)
        yaw = self.np_random.uniform(-0.6, 0.6)
        tip = (
            np.asarray(options["tip"], dtype=np.float64)
            if "tip" in options
            else self._draw_tip(pose)
        )
        self._simulation.start((*tip, CONTACT_HEIGHT), float(options.get("yaw", yaw)), pose)
        self._simulation.show_target(self._target)
        self._kick = self.np_random.uniform(-math.pi, math.pi)
        self._steps = 0
        self._images: list[tuple[int, NDArray[Any], NDArray[Any]]] = []
        return self._observe(), self._info()

    def step(self, action: ArrayLike) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Move by one control step of 0.01 s."""
        if self._target is None:
            raise ResetNeeded("the environment must be reset first")
        velocity = np.asarray(action, dtype=np.float64)
        if velocity.shape != (7,) or not np.isfinite(velocity).all():
            raise ValueError(f"action must be seven finite numbers, rad/s, got {action!r}")
        self._simulation.step(velocity, self._push())
        self._steps += 1
        info = self._info()
        error = math.hypot(info["distance"], 0.07 * info["angle"])
        return self._observe(), -error, bool(info["is_success"] or info["fallen"]), False, info

    def render(self) -> NDArray[np.uint8] | None:
        """Return a picture, if `render_mode` is "rgb_array"."""
        if self.render_mode is None:
            return None
        return self.picture(self._render_camera)

    def picture(self, camera: str) -> NDArray[np.uint8]:
        """A picture of the camera "outside" or "hand"."""
        return self._camera(f"show {camera}", camera, *self._shown)(self._simulation.data)[0]

    def close(self) -> None:
        """Give the contexts of the cameras back."""
        for camera in self._cameras.values():
            camera.close()
        self._cameras.clear()

    def _camera(self, key: str, name: str, width: int, height: int) -> Camera:
        if key not in self._cameras:
            shows = (scene.TARGET_GROUP,) if name == "outside" else ()
            self._cameras[key] = Camera(self._simulation.model, name, width, height, shows)
        return self._cameras[key]

    def _draw_pose(self) -> FloatArray:
        (left, right), (near, far) = self._area
        return np.array(
            [
                self.np_random.uniform(left, right),
                self.np_random.uniform(near, far),
                self.np_random.uniform(-math.pi, math.pi),
            ]
        )

    def _draw_tip(self, pose: FloatArray) -> FloatArray:
        """A place for the tip beside the object, 4 to 12 cm from it."""
        cos, sin = math.cos(pose[2]), math.sin(pose[2])
        outline = shapely.Polygon(
            self.object.corners @ np.array([[cos, sin], [-sin, cos]]) + pose[:2]
        )
        for _ in range(1000):
            tip = np.array(
                [self.np_random.uniform(0.42, 0.66), self.np_random.uniform(-0.22, 0.22)]
            )
            if 0.04 < outline.distance(shapely.Point(tip)) - scene.STICK_RADIUS < 0.12:
                return tip
        raise ValueError(
            f"object_pose={pose.tolist()}: no place for the tip beside it; name one as the option tip"
        )

    def _push(self) -> FloatArray | None:
        """The force from outside in this step, if there is one."""
        if self._kick_step is None or not self._kick_step <= self._steps < self._kick_step + 20:
            return None
        return self._kick_force * np.array([math.cos(self._kick), math.sin(self._kick), 0.0])

    def _observe(self) -> Observation:
        simulation = self._simulation
        depth_noise, force_noise, joint_noise = self._noises
        scale = force_noise * np.array([1.0, 1.0, 1.0, 0.02, 0.02, 0.02])
        assert self._target is not None
        observation: Observation = {
            "q": simulation.joints + self.np_random.normal(0.0, joint_noise, 7),
            "dq": simulation.speeds + self.np_random.normal(0.0, 10 * joint_noise, 7),
            "ft": simulation.wrench + self.np_random.normal(0.0, 1.0, 6) * scale,
            "target": self._target.copy(),
        }
        if self.obs_type == "pose":
            return observation | {"object_pose": simulation.pose}
        if self._steps % 5 == 0:
            camera = self._camera("hand", "hand", *self._size)
            color, depth = camera(simulation.data)
            depth += self.np_random.normal(0.0, depth_noise, depth.shape).astype(np.float32)
            self._images.append((self._steps, color, depth.clip(0.0, 10.0)))
        while len(self._images) > 1 and self._images[1][0] <= self._steps - self._delay:
            self._images.pop(0)
        taken, color, depth = self._images[0]
        age = np.array([(self._steps - taken) * CONTROL_STEP])
        return observation | {"rgb": color.copy(), "depth": depth.copy(), "image_age": age}

    def _info(self) -> dict[str, Any]:
        simulation = self._simulation
        assert self._target is not None
        pose, tip = simulation.pose, simulation.tip
        distance = float(np.linalg.norm(pose[:2] - self._target[:2]))
        angle = abs(math.remainder(pose[2] - self._target[2], math.tau))
        return {
            "object_pose": pose,
            "target_pose": self._target.copy(),
            "position": tip[:2],
            "tip": tip,
            "distance": distance,
            "angle": angle,
            "is_success": distance < SUCCESS_DISTANCE and angle < SUCCESS_ANGLE,
            "collision": simulation.collides,
            "fallen": simulation.fallen,
            "limit_margin": simulation.limit_margin,
            "self_distance": simulation.self_distance,
        }

    def _observation_space(self) -> spaces.Space[Observation]:
        width, height = self._size

        def box(bound: float, *shape: int) -> spaces.Box:
            return spaces.Box(-bound, bound, shape, np.float64)

        parts: dict[str, spaces.Space[Any]] = {
            "q": box(2 * math.pi, 7),
            "dq": box(_LARGE, 7),
            "ft": box(1e5, 6),
            "target": box(2 * math.pi, 3),
        }
        if self.obs_type == "pose":
            return cast(
                "spaces.Space[Observation]", spaces.Dict(parts | {"object_pose": box(_LARGE, 3)})
            )
        parts["rgb"] = spaces.Box(0, 255, (height, width, 3), np.uint8)
        parts["depth"] = spaces.Box(0.0, 10.0, (height, width), np.float32)
        parts["image_age"] = spaces.Box(0.0, _LARGE, (1,), np.float64)
        return cast("spaces.Space[Observation]", spaces.Dict(parts))
