"""The pushT task as a Gymnasium environment."""

import math
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import ArrayLike, NDArray

from aicon_envs.pusht.episode import Episode, start_episode
from aicon_envs.pusht.geometry import Point, place
from aicon_envs.pusht.goal import Goal
from aicon_envs.pusht.kick import kicked
from aicon_envs.pusht.objects import PushObject, resolve_object
from aicon_envs.pusht.overlay import Overlay
from aicon_envs.pusht.simulation import CONTROL_STEP, SIZE, Simulation
from aicon_envs.pusht.spaces import (
    AGENT,
    GOAL,
    KEYPOINTS,
    PIXELS,
    Action,
    Observation,
    ObsType,
    action_space,
    check_action,
    observation_space,
)
from aicon_envs.pusht.variant import DEFAULT_SPEED, Variant

SUCCESS_COVERAGE = 0.95
"""Share of the goal that the object must cover for success."""


class PushTEnv(gym.Env[Observation, Action]):
    """A disc pushes a T, or another object, until it covers its goal pose.

    Physics, default starts and pictures are those of gym-pusht 0.1.8: with the same seed and actions, both give the
    same episode. Positions are in px of a world of 512 x 512, y points down in pictures; a control step is 0.1 s.

    ## Action
    | `action_mode` | space | meaning |
    |---|---|---|
    | "position" | `Box(0, 512, (2,), float32)` | target of the pusher's PD controller, px; clipped to the box |
    | "velocity" | `Box(-v, v, (2,), float32)` | velocity for the whole step, px/s; its norm is limited to v |

    v is `velocity_limit`, or 400. A velocity is also limited such that the pusher's centre stays in the world. The
    pusher is kinematic: no contact stops it. Walls stop the object only.

    ## Observation
    float64, except pixels (uint8). The default is not gym-pusht's, which is "state".

    | `obs_type` | observation |
    |---|---|
    | "environment_state_agent_pos" | `environment_state` (2N,): the N keypoints x0, y0, x1, ...; `agent_pos` (2,) |
    | "state" | (5,): pusher x, y, object x, y and angle in [0, 2π) |
    | "pixels" | (observation_height, observation_width, 3) |
    | "pixels_agent_pos" | `pixels` and `agent_pos` |

    `observe_goal=True` adds `goal_pose` (3,): x, y, angle; for dictionaries only. The bounds are gym-pusht's, 0 to 512;
    as there, about 6 starts in 1000 put a corner behind a wall, which at first reads a few px more.

    ## Reward
    min(coverage / 0.95, 1), coverage = area(object ∩ goal) / area(object).

    ## Start
    Random, as gym-pusht draws it. With `goal_pose="random"` the goal is drawn after that, uniform among the poses at
    which the object lies between the walls. `reset(options=...)` takes `reset_to_state`: pusher x, y, object x, y and
    angle, set exactly (gym-pusht sets another pose and runs a sub-step, as does `legacy_reset=True`); `goal_pose`: a
    pose or "random"; and `noise_seed`: seeds action noise, kicks and the noise of wrappers apart from the rest.

    ## End
    Terminates at success, coverage > 0.95, after the last jump of the goal. The registered limit is 300 steps.

    ## Info
    gym-pusht's: `pos_agent` (2,), `vel_agent` (2,), `block_pose` (3,), `goal_pose` (3,), `n_contacts` (1 if anything
    touched in the step, else 0), `is_success` and `coverage`; and `pose_error`, √(|Δg|² + (r Δθ)²) px, with g the
    centre of gravity and r the radius of gyration.

    ## Arguments
    `obs_type` and `observe_goal`; `render_mode`: None or "rgb_array"; `object`: "T", "L", "U", "Z", "H", "plus",
    "quadrilateral", a `PushObject` or the vertices of a polygon; `observation_width`, `observation_height`,
    `visualization_width`, `visualization_height`: sizes of the pictures; and the options of `Variant` by name:

    | option | meaning |
    |---|---|
    | `goal_pose` | (x, y, angle), px and rad, or "random"; (256, 256, π/4) |
    | `action_mode`, `velocity_limit` | see above; in the mode "position" the limit holds in every sub-step |
    | `action_noise` | σ of Gaussian noise on the target offset, px per axis and step (on the velocity: σ / 0.1 s) |
    | `goal_jumps`, `goal_jump_interval` | the goal jumps so many times, each 40 to 120 steps after the last |
    | `kick_interval`, `kick` | every so many steps the object is shifted by up to 30 px and turned by up to 0.5 rad |
    | `start_distribution` | "0.1.8", or "0.1.5": the starts of that version of gym-pusht, same seed, same start |
    | `legacy_reset` | see above |

    ## Version history
    v0: first version.

    Example:
        >>> import gymnasium as gym
        >>> import aicon_envs
        >>> env = gym.make("aicon/PushT-v0", object="L", action_noise=2.0)
        >>> observation, info = env.reset(seed=0)
        >>> observation["environment_state"].shape, sorted(info)[:3]
        ((12,), ['block_pose', 'coverage', 'goal_pose'])
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 10}

    def __init__(
        self,
        obs_type: ObsType = "environment_state_agent_pos",
        render_mode: str | None = None,
        object: str | PushObject | ArrayLike = "T",
        observe_goal: bool = False,
        observation_width: int = 96,
        observation_height: int = 96,
        visualization_width: int = 680,
        visualization_height: int = 680,
        **variant: Any,
    ) -> None:
        """Create the environment; see the class for the arguments.

        Raises:
            ValueError: If a value is not valid; the message names it and says what is.
            TypeError: If a keyword is unknown.
        """
        self.variant = Variant.from_options(variant)
        self.render_mode = check_render_mode(render_mode)
        self.overlay: Overlay | None = None
        self._object = resolve_object(object)
        self._obs_type, self._observe_goal = obs_type, observe_goal
        self._observed_size = check_size("observation", observation_width, observation_height)
        self._shown_size = check_size("visualization", visualization_width, visualization_height)
        count = len(self._object.keypoints)
        self.observation_space = observation_space(obs_type, count, observe_goal, *self._observed_size[::-1])
        self.action_space = action_space(self.variant.action_mode, self.variant.velocity_limit)
        self._episode: Episode | None = None

    @property
    def object(self) -> PushObject:
        """What is pushed."""
        return self._object

    @property
    def noise(self) -> np.random.Generator:
        """Source of what is random during the current episode; wrappers spawn theirs from it."""
        return self._running.noise

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start an episode; see the class for the options."""
        super().reset(seed=seed)
        self._episode = start_episode(self._object, self.variant, options, seed, self.np_random)
        self._goal = Goal(self._object, self._episode.goal)
        self._jumps_left = self._episode.jumps[::-1]
        self._steps = 0
        self._target: Point | None = None
        info = self._evaluate()
        return self._observe(), info | {"is_success": False}

    def step(self, action: Action) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Move by one control step; see the class for the action."""
        command = check_action(action)
        self._disturb()
        self._move(*command)
        self._steps += 1
        info = self._evaluate()
        reward = min(max(info["coverage"] / SUCCESS_COVERAGE, 0.0), 1.0)
        return self._observe(), reward, info["is_success"], False, info

    def render(self) -> NDArray[np.uint8] | None:
        """Return a picture, (visualization_height, visualization_width, 3), if `render_mode` is "rgb_array".

        It shows the target of the last step as a cross, and `overlay` if there is one.
        """
        if self.render_mode is None:
            return None
        from aicon_envs.pusht.rendering import draw_view  # only pictures need pygame

        return draw_view(self._running.simulation, self._goal, self._shown_size, self._target, self.overlay)

    @property
    def _running(self) -> Episode:
        if self._episode is None:
            raise ResetNeeded("the environment must be reset first")
        return self._episode

    def _disturb(self) -> None:
        """Kick the object and let the goal jump, before the step in which it is due."""
        episode, variant = self._running, self.variant
        if variant.kick_interval is not None and self._steps and self._steps % variant.kick_interval == 0:
            simulation = episode.simulation
            simulation.pose = kicked(self._object, simulation.pose, simulation.pusher, variant.kick, episode.noise)
        if self._jumps_left and self._steps == self._jumps_left[-1].step:
            self._goal = Goal(self._object, self._jumps_left.pop().pose)

    def _move(self, x: float, y: float) -> None:
        simulation, variant = self._running.simulation, self.variant
        if variant.action_mode == "position":
            noise_x, noise_y = self._draw_noise(variant.action_noise)
            self._target = _clip(x + noise_x, 0.0, SIZE), _clip(y + noise_y, 0.0, SIZE)
            simulation.steer(self._target, variant.velocity_limit or math.inf)
        else:
            limit = variant.velocity_limit or DEFAULT_SPEED
            share = limit / max(math.hypot(x, y), limit)
            noise_x, noise_y = self._draw_noise(variant.action_noise / CONTROL_STEP)
            velocity = x * share + noise_x, y * share + noise_y
            simulation.drive(_within_world(simulation.pusher, velocity))

    def _draw_noise(self, sigma: float) -> Point:
        if sigma == 0.0:
            return 0.0, 0.0
        x, y = self._running.noise.normal(0.0, sigma, 2).tolist()
        return x, y

    def _observe(self) -> Observation:
        simulation = self._running.simulation
        pusher, pose = simulation.pusher, simulation.pose
        if self._obs_type == "state":
            return np.array([*pusher, pose[0], pose[1], pose[2] % (2.0 * math.pi)])
        if self._obs_type == "pixels":
            return self._pixels(simulation)
        if self._obs_type == "pixels_agent_pos":
            observation = {PIXELS: self._pixels(simulation), AGENT: np.array(pusher)}
        else:
            keypoints = place(self._object.keypoints, pose)
            observation = {KEYPOINTS: keypoints.ravel(), AGENT: np.array(pusher)}
        if self._observe_goal:
            observation[GOAL] = np.array(self._goal.pose)
        return observation

    def _pixels(self, simulation: Simulation) -> NDArray[np.uint8]:
        from aicon_envs.pusht.rendering import draw_observation  # only pictures need pygame

        return draw_observation(simulation, self._goal, self._observed_size)

    def _evaluate(self) -> dict[str, Any]:
        simulation = self._running.simulation
        pose = simulation.pose
        coverage = self._goal.coverage(pose)
        return {
            "pos_agent": np.array(simulation.pusher),
            "vel_agent": np.array(simulation.velocity),
            "block_pose": np.array(pose),
            "goal_pose": np.array(self._goal.pose),
            "n_contacts": int(simulation.touched),
            "is_success": coverage > SUCCESS_COVERAGE and not self._jumps_left,
            "coverage": coverage,
            "pose_error": self._goal.error(pose),
        }


def check_render_mode(render_mode: str | None) -> str | None:
    """Return the render mode.

    Raises:
        ValueError: If it is neither None nor "rgb_array".
    """
    if render_mode not in (None, "rgb_array"):
        raise ValueError(f'render_mode must be None or "rgb_array", got {render_mode!r}')
    return render_mode


def check_size(name: str, width: int, height: int) -> tuple[int, int]:
    """Return (width, height) of a picture.

    Raises:
        ValueError: If one is not an integer >= 1.
    """
    for side, value in (("width", width), ("height", height)):
        if not isinstance(value, int) or value < 1:
            raise ValueError(f"{name}_{side} must be an integer >= 1, got {value!r}")
    return width, height


def _clip(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)


def _within_world(position: Point, velocity: Point) -> Point:
    """Limit each component of a velocity, px/s, such that the pusher is in the world after a control step."""
    x, y = (
        _clip(speed, -start / CONTROL_STEP, (SIZE - start) / CONTROL_STEP)
        for start, speed in zip(position, velocity, strict=True)
    )
    return x, y
