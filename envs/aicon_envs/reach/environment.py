"""Reaching with an arm, as a Gymnasium environment."""

import math
from typing import Any, get_args

import mujoco
import numpy as np
from numpy.typing import ArrayLike

from aicon_envs.arm_push.arm_env import ArmEnv
from aicon_envs.arm_push.spaces import Observation, action_space
from aicon_envs.arrays import FloatArray
from aicon_envs.checks import check_action, check_choice, check_integer, check_number, check_numbers
from aicon_envs.reach.reset import EpisodeDrawer, EpisodeStart, Start
from aicon_envs.reach.robots import Robot, find_file, find_home, resolve_robot
from aicon_envs.reach.scene import build_scene
from aicon_envs.reach.simulation import CONTROL_STEP, Simulation
from aicon_envs.reach.spaces import Target, observation_space

_REWARD_RADIUS = 0.2
"""A turn by 1 rad costs as much as a shift by this, m."""


class ReachEnv(ArmEnv[Simulation, EpisodeStart]):
    """A robot reaches for a position or pose, within its limits and without touching anything.

    ## Description
    Any robot with a tip that a URDF describes, such as those of `example-robot-data`. The physics
    are MuJoCo's at 500 Hz, with torque limits; gravity is compensated. All coordinates are in the
    frame of the robot's root, m, with z up. A control step is 0.02 s. Whether the robot touches
    itself is what MuJoCo says of its collision shapes, of which it takes the convex hulls; left out
    are links with only one joint between them, pairs that the SRDF disables, and pairs that touch
    in almost every posture.

    ## Observation space
    | key | space | meaning |
    |---|---|---|
    | `q`, `dq` | (n,) | values of the joints (rad or m) and their velocities |
    | `target_position` | (3,) | where the tip should be, m |
    | `target_orientation` | (3,) | with `target="axis"`: where its z axis should point |
    | | (4,) | with `target="pose"`: its rotation, a quaternion (w, x, y, z) |
    | `ball_1`, `ball_2`, … | (3,) | where the middle of each ball is, m |

    ## Action space
    `Box((n,), float32)`: velocity of each joint, rad/s or m/s, at 50 Hz, up to `speed` or what the
    description allows; what is beyond is clipped, and jumps are followed at 40 rad/s² (m/s²).

    ## Rewards
    -√(|Δ|² + (r Δθ)²) per step, m, with r = 0.2 m.

    ## Starting state
    The target is where the tip is at random joints that are free of contact and away from their
    stops, so that it can be reached. Balls start, and stay, away from the robot at the target and
    from its first two joints, and are about on its way; those that move go to and fro. The options
    `joints` and `target_joints` (n,) of `reset` set the start and the target.

    ## Episode end
    Terminates at success: within `position_tolerance` and, if it counts, `angle_tolerance`. The
    registered limit is 1,000 steps, 20 s.

    ## Arguments
    | argument | meaning |
    |---|---|
    | `robot` | a name of `ROBOTS` or a `Robot` |
    | `target` | "position", "axis" (position and approach axis, z of the tip) or "pose" |
    | `start` | "home" or "random" |
    | `speed` | largest speed of the joints that turn, rad/s |
    | `balls` | number of balls |
    | `ball_radius` | their radius, m |
    | `ball_speed` | their largest speed, m/s; 0 for balls at rest |
    | `position_tolerance` | m |
    | `angle_tolerance` | rad |
    | `render_mode` | None or "rgb_array" |
    | `render_width`, `render_height` | of rendered pictures, px |

    ## Info
    `position` (3,): the tip, m; `distance`, m; `angle`, rad, 0 where it does not count;
    `is_success`; during the last step: `self_contact`, `ball_contact`, `collision`, one of them;
    `limit_violation`, a joint beyond its limits; `self_gap` and `ball_gap`, the smallest gaps, m,
    at most 0.05; `limit_margin`, the smallest distance of a joint to its limits, rad or m. At the
    start also `target_joints` (n,), at which the tip is at the target, rad or m.

    ## Version history
    v0: first version.

    Example:
        >>> import gymnasium as gym
        >>> import aicon_envs
        >>> env = gym.make("aicon/Reach-v0", robot="ur5", target="pose")
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 50}

    def __init__(
        self,
        robot: str | Robot = "panda",
        target: Target = "pose",
        start: Start = "home",
        speed: float = 1.5,
        balls: int = 0,
        ball_radius: float = 0.08,
        ball_speed: float = 0.0,
        position_tolerance: float = 0.01,
        angle_tolerance: float = 0.05,
        render_mode: str | None = None,
        render_width: int = 640,
        render_height: int = 480,
    ) -> None:
        """Create the environment; see the class for the arguments.

        Raises:
            ValueError: If a value is not valid; the message names it and says what is.
        """
        super().__init__(render_mode, render_width, render_height)

        # Arguments, ...
        check_choice("target", target, get_args(Target))
        check_choice("start", start, get_args(Start))
        balls = check_integer("balls", balls, 0)
        ball_radius = check_number("ball_radius", ball_radius, positive=True)
        ball_speed = check_number("ball_speed", ball_speed)
        speed = check_number("speed", speed, positive=True)

        self.robot, self.target = resolve_robot(robot), target
        self._position_tolerance = check_number("position_tolerance", position_tolerance, True)
        self._angle_tolerance = check_number("angle_tolerance", angle_tolerance, True)

        # ... the simulated robot, ...
        scene = build_scene(self.robot, balls, ball_radius)
        self._simulation = Simulation(scene)
        self._speed = np.where(scene.turns, np.minimum(scene.speed, speed), scene.speed)
        self._balls, self._ball_radius = balls, ball_radius
        self.observation_space = observation_space(len(scene.joints), target, balls)
        self.action_space = action_space(self._speed)

        # ... and how its episodes begin.
        home = find_home(self.robot, scene.low, scene.high)
        self._draw = EpisodeDrawer(self._simulation, home, start, balls, ball_radius, ball_speed)

    def description(self) -> dict[str, Any]:
        """What a policy may know of the robot, as plain data.

        Returns:
            ``urdf``, ``srdf``: files, the second may be None; ``tip``: name of the link;
            ``joints``: their names; ``low``, ``high``: their limits, rad or m; ``speed``: rad/s or
            m/s; ``balls``: their number; ``ball_radius``: m; ``time_step``: s.
        """
        scene, srdf = self._simulation.scene, self.robot.srdf
        return {
            "urdf": str(find_file(self.robot.urdf)),
            "srdf": None if srdf is None else str(find_file(srdf)),
            "tip": self.robot.tip,
            "joints": scene.joints,
            "low": tuple(scene.low.tolist()),
            "high": tuple(scene.high.tolist()),
            "speed": tuple(self._speed.tolist()),
            "balls": self._balls,
            "ball_radius": self._ball_radius,
            "time_step": CONTROL_STEP,
        }

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start an episode; see the class for the options."""
        super().reset(seed=seed)
        episode = self._draw(options, self.np_random)
        self._episode, self._steps = episode, 0

        self._target = self._simulation.tip_at(episode.target_joints)
        self._simulation.start(episode.joints, self._ball_positions())
        self._simulation.show_target(*self._target)
        return self._observe(), self._info() | {"target_joints": episode.target_joints.copy()}

    def step(self, action: ArrayLike) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Move by one control step of 0.02 s."""
        self._current_episode()
        meaning = "joint velocities in rad/s or m/s"
        velocity = check_action(action, self._speed.shape, meaning)

        self._steps += 1
        limited = np.clip(velocity, -self._speed, self._speed)
        self._simulation.step(limited, self._ball_positions())

        info = self._info()
        error = math.hypot(info["distance"], _REWARD_RADIUS * info["angle"])
        return self._observe(), -error, bool(info["is_success"]), False, info

    def move_target(self, position: ArrayLike) -> None:
        """Put the target elsewhere while the episode goes on; whether it can be reached is unknown.

        Args:
            position: Where the tip should be, ``(3,)``, m.
        """
        self._current_episode()
        place = check_numbers("position", position, "(x, y, z), finite, in m", 3)
        self._target = np.array(place), self._target[1]
        self._simulation.show_target(*self._target)

    def move_ball(self, number: int, position: ArrayLike) -> None:
        """Put a ball, or the middle of its way, elsewhere while the episode goes on.

        Args:
            number: 1 for the first.
            position: Where, ``(3,)``, m.

        Raises:
            ValueError: If there is no such ball, or the position is not usable.
        """
        episode = self._current_episode()
        place = check_numbers("position", position, "(x, y, z), finite, in m", 3)
        balls = list(episode.balls)
        if check_integer("number", number, 1) > len(balls):
            raise ValueError(f"number must be from 1 to {len(balls)}, got {number}")

        balls[number - 1] = balls[number - 1]._replace(middle=np.array(place))
        self._episode = episode._replace(balls=tuple(balls))

        # Seen at once, also where nothing moves.
        self._simulation.data.mocap_pos[1:] = self._ball_positions()
        mujoco.mj_kinematics(self.model, self.data)

    def _ball_positions(self) -> FloatArray:
        """Return where the balls are now, ``(balls, 3)``, m."""
        time = self._steps * CONTROL_STEP
        positions = [path.at(time) for path in self._current_episode().balls]
        return np.array(positions).reshape(-1, 3)

    def _observe(self) -> Observation:
        position, rotation = self._target
        observation = {
            "q": self._simulation.joints,
            "dq": self._simulation.speeds,
            "target_position": position.copy(),
        }

        if self.target == "axis":
            observation["target_orientation"] = rotation[:, 2].copy()
        elif self.target == "pose":
            observation["target_orientation"] = _to_quaternion(rotation)
        for number, ball in enumerate(self._ball_positions(), start=1):
            observation[f"ball_{number}"] = ball
        return observation

    def _info(self) -> dict[str, Any]:
        simulation = self._simulation
        position, rotation = simulation.tip
        distance = float(np.linalg.norm(position - self._target[0]))
        angle = self._angle(rotation)
        gaps, margin = simulation.gaps, simulation.limit_margin

        return {
            "position": position,
            "distance": distance,
            "angle": angle,
            "is_success": distance < self._position_tolerance and angle < self._angle_tolerance,
            "self_contact": gaps.to_itself < 0.0,
            "ball_contact": gaps.to_balls < 0.0,
            "collision": min(gaps) < 0.0,
            "limit_violation": margin < 0.0,
            "self_gap": gaps.to_itself,
            "ball_gap": gaps.to_balls,
            "limit_margin": margin,
        }

    def _angle(self, rotation: FloatArray) -> float:
        """Return the angle between the tip and the target as far as it counts, rad."""
        _, target = self._target
        if self.target == "position":
            return 0.0

        # The sine is exact for small angles, the cosine is not.
        if self.target == "axis":
            cosine = float(rotation[:, 2] @ target[:, 2])
            sine = float(np.linalg.norm(np.cross(rotation[:, 2], target[:, 2])))
            return math.atan2(sine, cosine)

        between = rotation.T @ target
        cosine = (float(np.trace(between)) - 1.0) / 2.0
        sine = float(np.linalg.norm(between - between.T)) / (2.0 * math.sqrt(2.0))
        return math.atan2(sine, cosine)


def _to_quaternion(rotation: FloatArray) -> FloatArray:
    """Return a rotation matrix ``(3, 3)`` as (w, x, y, z)."""
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, rotation.ravel())
    return quaternion
