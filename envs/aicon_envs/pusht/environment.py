"""The pushT task as a Gymnasium environment."""

import math
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium.error import ResetNeeded
from numpy.typing import ArrayLike, NDArray

from aicon_envs.checks import check_action, check_render_mode, check_size, fields_of
from aicon_envs.pusht.disturbances import draw_kicked_pose
from aicon_envs.pusht.geometry import Point, clip, place
from aicon_envs.pusht.goal import Goal
from aicon_envs.pusht.objects import PushObject, resolve_object
from aicon_envs.pusht.reset import EpisodeStart, draw_episode
from aicon_envs.pusht.settings import KICK, TaskSettings
from aicon_envs.pusht.simulation import SIZE, Simulation
from aicon_envs.pusht.spaces import (
    AGENT,
    GOAL,
    KEYPOINTS,
    PIXELS,
    POSITION,
    Action,
    Observation,
    ObsType,
    action_space,
    observation_space,
)

SUCCESS_COVERAGE = 0.95
"""Share of the goal that the object must cover for success."""


class PushTEnv(gym.Env[Observation, Action]):
    """A disc pushes a T, or another object, until it covers its goal pose.

    ## Description
    Physics, default starts and pictures are those of gym-pusht 0.1.8: with the same seed and
    actions, both give the same episode. Positions are in px of a world of 512 x 512, y points down
    in pictures; a control step is 0.1 s. The pusher is kinematic: no contact stops it. Walls stop
    the object only.

    ## Observation space
    float64, except pixels (uint8). The default is not gym-pusht's, which is "state".

    | `obs_type` | observation |
    |---|---|
    | "environment_state_agent_pos" | `environment_state` (2N,) and `agent_pos` (2,) |
    | "state" | (5,): pusher x, y, object x, y and angle in [0, 2π) |
    | "pixels" | (observation_height, observation_width, 3) |
    | "pixels_agent_pos" | `pixels` and `agent_pos` |

    `environment_state` are the N keypoints x0, y0, x1, ... of the object, `agent_pos` is the
    pusher's position. `observe_goal=True` adds `goal_pose` (3,): x, y, angle; for dictionaries
    only. The bounds are gym-pusht's, 0 to 512; as there, about 6 starts in 1000 put a corner behind
    a wall, which at first reads a few px more.

    ## Action space
    `Box(0, 512, (2,), float32)`: target of the pusher's PD controller, px, which is clipped to it.

    ## Rewards
    min(coverage / 0.95, 1), coverage = area(object ∩ goal) / area(object).

    ## Starting state
    Random, as gym-pusht draws it. With `goal_pose="random"` the goal is drawn after that, uniform
    among the poses at which the object lies between the walls. `reset(options=...)` takes

    | option | meaning |
    |---|---|
    | `reset_to_state` | pusher x, y, object x, y and angle, set exactly |
    | `goal_pose` | a pose or "random" |
    | `noise_seed` | seeds action noise, kicks and the noise of wrappers apart from the rest |

    (gym-pusht sets another pose than `reset_to_state` and runs a sub-step.)

    ## Episode end
    Terminates at success, coverage > 0.95, after the last jump of the goal. The registered limit is
    300 steps.

    ## Arguments
    `obs_type` and `observe_goal`; `render_mode`: None or "rgb_array"; `object`: "T", "L", "U", "Z",
    "H", "plus", "quadrilateral", a `PushObject` or the vertices of a polygon; `observation_width`,
    `observation_height`, `visualization_width`, `visualization_height`: sizes of the pictures; and
    the fields of `TaskSettings` by name:

    | argument | meaning |
    |---|---|
    | `goal_pose` | (x, y, angle), px and rad, or "random"; (256, 256, π/4) |
    | `velocity_limit` | largest speed of the pusher, px/s, in every sub-step |
    | `action_noise` | σ of Gaussian noise on the target offset, px per axis and step |
    | `goal_jumps` | the goal jumps so many times, each time 40 to 120 steps after the last |
    | `kick_interval` | steps between kicks of the object, by up to 30 px and 0.5 rad |

    ## Info
    gym-pusht's: `pos_agent` (2,), `vel_agent` (2,), `block_pose` (3,), `goal_pose` (3,),
    `n_contacts` (1 if anything touched in the step, else 0), `is_success` and `coverage`; and
    `pose_error`, √(|Δg|² + (r Δθ)²) px, with g the centre of gravity and r the radius of gyration.
    Under the names that this package's environments share: `position` (2,), the pusher's, px;
    `distance`, the pose error, px; and `collision`, always False: only success ends an episode.

    ## Copies
    `copy.deepcopy` and `pickle` give an environment in the same state, whose episode goes on number
    for number. They do the episode so far again, which takes as long as its steps.

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
        **settings: Any,
    ) -> None:
        """Create the environment; see the class for the arguments.

        Raises:
            ValueError: If a value is not valid; the message names it and says what is.
            TypeError: If a keyword is unknown.
        """
        self.settings = fields_of(TaskSettings, settings, type(self))
        self.render_mode = check_render_mode(render_mode)

        self._object = resolve_object(object)
        self._obs_type = obs_type
        self._observe_goal = observe_goal
        self._observed_size = check_size("observation", observation_width, observation_height)
        self._shown_size = check_size("visualization", visualization_width, visualization_height)

        # The space of what is seen depends on the object.
        num_keypoints = len(self._object.keypoints)
        self.observation_space = observation_space(
            obs_type, num_keypoints, observe_goal, self._observed_size
        )
        self.action_space = action_space()
        self._episode: EpisodeStart | None = None

    @property
    def object(self) -> PushObject:
        """What is pushed."""
        return self._object

    @property
    def noise(self) -> np.random.Generator:
        """Source of what is random in the current episode; wrappers spawn theirs from it."""
        return self._current_episode().noise

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start an episode; see the class for the options."""
        super().reset(seed=seed)

        episode = draw_episode(self._object, self.settings, options, self.np_random)
        self._episode = episode
        self._goal = Goal(self._object, episode.goal)
        self._jumps_left = episode.jumps[::-1]  # the next one last
        self._steps = 0
        self._target: Point | None = None

        # A start at the goal is no success yet: the first step is.
        info = self._evaluate()
        return self._observe(), info | {"is_success": False}

    def step(self, action: Action) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Move by one control step; see the class for the action."""
        self._current_episode()  # an error before the first reset
        x, y = check_action(action, (2,), POSITION).tolist()

        # A kick or a jump of the goal that is due comes before the move.
        self._disturb()
        self._steer((x, y))
        self._steps += 1

        info = self._evaluate()
        reward = clip(info["coverage"] / SUCCESS_COVERAGE, 0.0, 1.0)
        return self._observe(), reward, info["is_success"], False, info

    def render(self) -> NDArray[np.uint8] | None:
        """Return a picture, (visualization_height, visualization_width, 3), if in "rgb_array".

        It shows the target of the last step as a cross.
        """
        if self.render_mode is None:
            return None

        from aicon_envs.pusht.rendering import draw_view  # only pictures need pygame

        simulation = self._current_episode().simulation
        return draw_view(simulation, self._goal, self._shown_size, self._target)

    def _current_episode(self) -> EpisodeStart:
        if self._episode is None:
            raise ResetNeeded("the environment must be reset first")

        return self._episode

    def _disturb(self) -> None:
        """Kick the object and let the goal jump, before the step in which it is due."""
        episode = self._current_episode()
        simulation = episode.simulation

        interval = self.settings.kick_interval
        if interval is not None and self._steps > 0 and self._steps % interval == 0:
            simulation.pose = draw_kicked_pose(
                self._object, simulation.pose, simulation.pusher, KICK, episode.noise
            )

        if self._jumps_left and self._steps == self._jumps_left[-1].step:
            jump = self._jumps_left.pop()
            self._goal = Goal(self._object, jump.pose)

    def _steer(self, target: Point) -> None:
        """Let the pusher's controller go to a target, px, for one control step."""
        noise_x, noise_y = 0.0, 0.0
        if self.settings.action_noise > 0.0:
            noise_x, noise_y = self.noise.normal(0.0, self.settings.action_noise, 2).tolist()
        x = clip(target[0] + noise_x, 0.0, SIZE)
        y = clip(target[1] + noise_y, 0.0, SIZE)
        self._target = (x, y)

        limit = self.settings.velocity_limit or math.inf
        self._current_episode().simulation.steer(self._target, limit)

    def _observe(self) -> Observation:
        simulation = self._current_episode().simulation
        pusher, pose = simulation.pusher, simulation.pose

        if self._obs_type == "state":
            x, y, angle = pose
            return np.array([*pusher, x, y, angle % (2.0 * math.pi)])
        if self._obs_type == "pixels":
            return self._draw_pixels(simulation)

        # The others are dictionaries.
        observation: dict[str, NDArray[Any]] = {}
        if self._obs_type == "pixels_agent_pos":
            observation[PIXELS] = self._draw_pixels(simulation)
        else:
            observation[KEYPOINTS] = place(self._object.keypoints, pose).ravel()

        observation[AGENT] = np.array(pusher)
        if self._observe_goal:
            observation[GOAL] = np.array(self._goal.pose)

        return observation

    def _draw_pixels(self, simulation: Simulation) -> NDArray[np.uint8]:
        from aicon_envs.pusht.rendering import draw_observation  # only pictures need pygame

        return draw_observation(simulation, self._goal, self._observed_size)

    def _evaluate(self) -> dict[str, Any]:
        simulation = self._current_episode().simulation
        pose = simulation.pose
        coverage = self._goal.coverage(pose)
        error = self._goal.error(pose)

        return {
            "pos_agent": np.array(simulation.pusher),
            "vel_agent": np.array(simulation.velocity),
            "block_pose": np.array(pose),
            "goal_pose": np.array(self._goal.pose),
            "n_contacts": int(simulation.touched),
            "is_success": coverage > SUCCESS_COVERAGE and not self._jumps_left,
            "coverage": coverage,
            "pose_error": error,
            "position": np.array(simulation.pusher),
            "distance": error,
            "collision": False,
        }
