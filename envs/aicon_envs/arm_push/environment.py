"""Pushing with an arm, as a Gymnasium environment."""

import math
from typing import Any, get_args

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from aicon_envs.arm_push.arm_env import ArmEnv
from aicon_envs.arm_push.arms import ARMS
from aicon_envs.arm_push.capsules import robot_capsules
from aicon_envs.arm_push.description import describe
from aicon_envs.arm_push.hand_camera import HandCamera
from aicon_envs.arm_push.inverse_kinematics import home_of
from aicon_envs.arm_push.objects import Prism, resolve_object
from aicon_envs.arm_push.reset import (
    A_POSE,
    AREA,
    CONTACT_HEIGHT,
    Bounds,
    EpisodeStart,
    check_area,
    draw_episode,
)
from aicon_envs.arm_push.scene import TARGET_GROUP, build_scene
from aicon_envs.arm_push.simulation import CONTROL_STEP, Simulation
from aicon_envs.arm_push.spaces import Observation, ObsType, action_space, observation_space
from aicon_envs.arrays import FloatArray
from aicon_envs.checks import check_action, check_choice, check_integer, check_number, check_numbers
from aicon_envs.reach.robots import Robot, resolve_robot

SUCCESS_DISTANCE = 0.01
"""Largest distance between object and target for success, m."""

SUCCESS_ANGLE = math.radians(5.0)
"""Largest difference of their angles, rad."""

_REWARD_RADIUS = 0.07
"""A turn by 1 rad costs as much as a shift by this, m."""

_KICK_STEPS = 20
"""Control steps that a push from outside lasts."""

_TORQUE_NOISE = 0.02
"""Noise of torques in Nm for a noise of forces of 1 N."""

_SPEED_NOISE = 10
"""Noise of joint velocities in rad/s for a noise of joint angles of 1 rad."""


class ArmPushEnv(ArmEnv[Simulation, EpisodeStart]):
    """An arm pushes an object on a table into a target pose with a stick.

    ## Description
    The arm, a Panda unless `robot` says otherwise, has a push stick and a camera at its flange, and
    a force-torque sensor between them. The physics are MuJoCo's at 1 kHz, the description of the
    arm is that of `example-robot-data`. All coordinates are in the frame of the robot's base, m: x
    toward the table, z up from its top. A control step is 0.01 s. OpenGL does not survive a fork:
    where a process has rendered, `AsyncVectorEnv` needs `context="spawn"`.

    ## Observation space
    | key | space | meaning |
    |---|---|---|
    | `q`, `dq` | (n,) | angles (rad) and velocities (rad/s) of the n joints, by encoders |
    | `ft` | (6,) | force (N) and torque (Nm) at the flange in its frame, noisy, with tool weight |
    | `target` | (3,) | target pose of the object: x, y, angle |
    | `rgb` | (120, 160, 3) uint8 | the camera in the hand, 20 Hz |
    | `depth` | (120, 160) float32 | distance along its optical axis, m, noisy |
    | `image_age` | (1,) | age of the image, s; where it does not grow by 0.01 the image is new |

    With `obs_type="pose"` there is `object_pose` (3,) instead of the last three: the truth.

    ## Action space
    `Box((n,), float32)`: velocity of each joint, rad/s, up to what the description of the arm
    allows, for a Panda 2.175 (joints 1 to 4) and 2.61 (5 to 7), at 100 Hz.

    ## Rewards
    -√(|Δ|² + (r Δθ)²) per step, m, with r = 0.07 m.

    ## Starting state
    Poses of object and target are drawn from `area` with any angle, the tip upright beside the
    object. The options `object_pose`, `target_pose` (3,), `tip` (2,) and `yaw` of `reset` set them.

    ## Episode end
    Terminates at success, within 1 cm and 5°, and when the object falls off the table. The
    registered limit is 18,000 steps, 180 s.

    ## Arguments
    | argument | meaning |
    |---|---|
    | `robot` | "panda", "ur5" or a `Robot` |
    | `obs_type` | "rgbd" or "pose" |
    | `render_mode` | None or "rgb_array" |
    | `object` | a name of `OBJECT_NAMES`, a `Prism` or an outline, m |
    | `mass`, `friction` | of the object, 0.5 kg and 0.35 |
    | `image_delay` | from when an image is taken to when it arrives, s |
    | `depth_noise` | standard deviation, 3 mm |
    | `force_noise` | standard deviation, 0.1 N; torques a fiftieth |
    | `joint_noise` | standard deviation, 1e-4 rad; velocities ten times |
    | `area` | bounds in x and y within which start and target are drawn, m |
    | `kick_time` | when the object is pushed from outside, s, or None |
    | `kick_force` | with how much for 0.2 s, N |
    | `width`, `height` | of the images of the camera in the hand, px |
    | `render_width`, `render_height` | of rendered pictures, px |

    ## Info
    `object_pose`, `target_pose` (3,); `position` (2,): the tip; `tip` (3,); `distance`, m; `angle`,
    rad; `is_success`; `collision`: whether the robot touched itself or the table during the last
    step; `fallen`; at its end: `limit_margin`, rad, the joint nearest to its limits;
    `self_distance`, m, the smallest gap between parts of the robot that can meet: capsules of a
    Panda, and else its collision shapes, up to 50 mm.

    ## Version history
    v0: first version.

    Example:
        >>> import gymnasium as gym
        >>> import aicon_envs
        >>> env = gym.make("aicon/ArmPush-v0", robot="ur5", obs_type="pose")
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 20}
    outside_only = (TARGET_GROUP,)

    def __init__(
        self,
        robot: str | Robot = "panda",
        obs_type: ObsType = "rgbd",
        render_mode: str | None = None,
        object: str | Prism | ArrayLike = "T",
        mass: float = 0.5,
        friction: float = 0.35,
        image_delay: float = 0.0,
        depth_noise: float = 0.003,
        force_noise: float = 0.1,
        joint_noise: float = 1e-4,
        area: Bounds = AREA,
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
        super().__init__(render_mode, render_width, render_height)
        check_choice("obs_type", obs_type, get_args(ObsType))
        mass = check_number("mass", mass, positive=True)
        friction = check_number("friction", friction, positive=True)

        self.robot = resolve_robot(robot, ARMS)
        self.object = resolve_object(object)
        self.obs_type = obs_type
        width, height = check_integer("width", width, 1), check_integer("height", height, 1)

        # The scene, and what its robot makes of the spaces.
        model = build_scene(self.robot, self.object, mass, friction)
        capsules = robot_capsules(self.robot, model)
        self._simulation = Simulation(model, home_of(model, self.robot), capsules)
        self.observation_space = observation_space(model.nu, obs_type, width, height)
        self.action_space = action_space(model.actuator_ctrlrange[:, 1])

        # What disturbs: noise, and pushes from outside.
        self._area = check_area(area)
        self._force_noise = check_number("force_noise", force_noise)
        self._joint_noise = check_number("joint_noise", joint_noise)
        self._kick_step = None if kick_time is None else _to_steps("kick_time", kick_time)
        self._kick_force = check_number("kick_force", kick_force)

        self._image_size = width, height
        self._hand_camera = HandCamera(
            _to_steps("image_delay", image_delay), check_number("depth_noise", depth_noise)
        )

    def description(self) -> dict[str, Any]:
        """The robot as plain data, see :func:`aicon_envs.arm_push.description.describe`."""
        return describe(self._simulation.model, self.robot, *self._image_size)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start an episode; see the class for the options."""
        super().reset(seed=seed)

        # A start that cannot be reached is an error that leaves the last episode as it is.
        episode = draw_episode(self.object, self._area, options, self.np_random)
        tip = (*episode.tip, CONTACT_HEIGHT)
        self._simulation.start(tip, episode.yaw, episode.object_pose, episode.target_pose)
        self._episode = episode

        # Drawn in any case, such that a kick changes nothing else.
        self._kick_heading = self.np_random.uniform(-math.pi, math.pi)
        self._hand_camera.restart()
        self._steps = 0
        return self._observe(), self._info()

    def step(self, action: ArrayLike) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Move by one control step of 0.01 s."""
        self._current_episode()
        command = check_action(action, self.action_space.shape or (), "joint velocities in rad/s")
        self._simulation.step(command, self._external_force())
        self._steps += 1

        info = self._info()
        error = math.hypot(info["distance"], _REWARD_RADIUS * info["angle"])
        terminated = bool(info["is_success"] or info["fallen"])
        return self._observe(), -error, terminated, False, info

    def move_target(self, pose: ArrayLike) -> None:
        """Put the target elsewhere while the episode goes on.

        Args:
            pose: The object's target (x, y, angle), m and rad.
        """
        episode = self._current_episode()
        target = np.array(check_numbers("pose", pose, A_POSE, 3))
        self._episode = episode._replace(target_pose=target)
        self._simulation.show_target(target)
        mujoco.mj_kinematics(self.model, self.data)

    def move_object(self, pose: ArrayLike) -> None:
        """Put the object elsewhere while the episode goes on, at rest.

        Args:
            pose: Its (x, y, angle), m and rad.
        """
        self._current_episode()
        place = check_numbers("pose", pose, A_POSE, 3)
        self._simulation.place(place)

    def _external_force(self) -> FloatArray | None:
        """Return the force from outside in this step, ``(3,)``, N, if there is one."""
        if self._kick_step is None:
            return None

        steps_since_kick = self._steps - self._kick_step
        if not 0 <= steps_since_kick < _KICK_STEPS:
            return None

        heading = self._kick_heading
        return self._kick_force * np.array([math.cos(heading), math.sin(heading), 0.0])

    def _observe(self) -> Observation:
        observation = self._sense_robot() | {"target": self._current_episode().target_pose.copy()}
        if self.obs_type == "pose":
            return observation | {"object_pose": self._simulation.pose}

        return observation | self._sense_image()

    def _sense_robot(self) -> Observation:
        """Read encoders and wrist, with noise."""
        simulation, generator = self._simulation, self.np_random
        # Encoders: the velocities are noisier than the angles.
        count = len(simulation.joints)
        joint_noise = generator.normal(0.0, self._joint_noise, count)
        speed_noise = generator.normal(0.0, _SPEED_NOISE * self._joint_noise, count)

        # Wrist: force, then torque.
        deviations = self._force_noise * np.repeat([1.0, _TORQUE_NOISE], 3)
        wrench_noise = generator.normal(0.0, 1.0, 6) * deviations

        return {
            "q": simulation.joints + joint_noise,
            "dq": simulation.speeds + speed_noise,
            "ft": simulation.wrench + wrench_noise,
        }

    def _sense_image(self) -> Observation:
        """Take an image when one is due, and return the newest that has arrived."""
        if self._hand_camera.is_due(self._steps):
            camera = self._open_camera("hand", "hand", *self._image_size)
            self._hand_camera.take(camera, self._simulation.data, self._steps, self.np_random)

        image = self._hand_camera.latest(self._steps)
        age = (self._steps - image.step) * CONTROL_STEP
        return {
            "rgb": image.color.copy(),
            "depth": image.depth.copy(),
            "image_age": np.array([age]),
        }

    def _info(self) -> dict[str, Any]:
        simulation = self._simulation
        pose, tip = simulation.pose, simulation.tip
        target = self._current_episode().target_pose

        # The shorter way around.
        distance = float(np.linalg.norm(pose[:2] - target[:2]))
        angle = abs(math.remainder(pose[2] - target[2], math.tau))

        return {
            "object_pose": pose,
            "target_pose": target.copy(),
            "position": tip[:2].copy(),
            "tip": tip,
            "distance": distance,
            "angle": angle,
            "is_success": distance < SUCCESS_DISTANCE and angle < SUCCESS_ANGLE,
            "collision": simulation.collides,
            "fallen": simulation.fallen,
            "limit_margin": simulation.margin(),
            "self_distance": simulation.self_distance,
        }


def _to_steps(name: str, duration: float) -> int:
    """Return a duration, s, as control steps."""
    return round(check_number(name, duration) / CONTROL_STEP)
