"""What methods of inverse kinematics have in common when they control an arm."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from aicon_baselines.agents.reach.random_places import RandomPlaces
from aicon_baselines.evaluation.predictor import starting_rows
from aicon_baselines.extras import require
from aicon_torch.errors import OptionError, choices
from aicon_torch.validation import check_not_negative, check_positive

if TYPE_CHECKING:
    from aicon_baselines.agents.reach.kinematics import Kinematics

FloatArray = NDArray[np.float64]

ORIENTATIONS = ("free", "axis", "full")
"""What of the orientation may count: nothing, the direction of the tip's axis, or all of it."""


@dataclass(frozen=True)
class InverseKinematics:
    """A method that maps the error of the tip to velocities of the joints.

    It has no memory, but with `places`: held up, it goes elsewhere within its own limits.

    Attributes:
        robot: The file of the URDF.
        tip: The link that reaches.
        srdf: Says which links need not be compared.
        orientation: "free", "axis" or "full": what of the orientation counts.
        speed: Largest speed of the joints that turn, rad/s.
        balls: Number of balls.
        ball_radius: Their radius, m.
        dt: Time step, s.
        gain: Rate at which an error should vanish, 1/s.
        lever: A rotation by 1 rad counts as much as a motion by this, m.
        stop_distance: Distance of the joints from their stops, rad or m.
        places: Whether it goes to random places where it is held up: see :class:`RandomPlaces`.
        modules: What it needs.
        extra: The extra that brings it.

    Raises:
        ComparisonError: If a module is not installed; it says how to install it.
        OptionError: If an option has a value that it cannot have.
    """

    robot: str = ""
    tip: str = ""
    srdf: str | None = None
    orientation: str = "free"
    speed: float = 1.5
    balls: int = 0
    ball_radius: float = 0.08
    dt: float = 0.02
    gain: float = 20.0
    lever: float = 0.2
    stop_distance: float = 0.02
    places: bool = False

    modules: ClassVar[tuple[str, ...]] = ()
    extra: ClassVar[str] = "peers"

    def __post_init__(self) -> None:
        """Check the options, and that what it needs is there."""
        if self.orientation not in ORIENTATIONS:
            valid = choices(ORIENTATIONS)
            raise OptionError(f"orientation={self.orientation!r}: expected one of {valid}.")
        check_positive(self, ("speed", "ball_radius", "dt", "gain", "lever"))
        floats = [field.name for field in fields(self) if isinstance(field.default, float)]
        check_not_negative(self, floats)

        require(type(self).__name__, self.extra, *self.modules)

    @cached_property
    def kinematics(self) -> "Kinematics":
        """The robot."""
        from aicon_baselines.agents.reach.kinematics import Kinematics

        return Kinematics(self.robot, self.tip, self.srdf, self.balls, self.ball_radius, self.speed)

    def predict(
        self,
        observation: dict[str, NDArray[Any]],
        state: Any = None,
        episode_start: NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[FloatArray, list[RandomPlaces]]:
        """Choose the next velocities (B, n); see `aicon_baselines.evaluation.Predictor`."""
        count = len(observation["q"])
        starts = starting_rows(count, state, episode_start)
        known = [self._fresh() if starts[row] else state[row] for row in range(count)]
        velocities = []
        for row in range(count):
            one = {name: values[row] for name, values in observation.items()}
            velocities.append(self._next(one, known[row]))
        return np.array(velocities), known

    def velocity(
        self, observation: Mapping[str, FloatArray], way: FloatArray | None = None
    ) -> FloatArray:
        """Velocities of the joints ``(n,)``, rad/s or m/s, in one episode.

        Args:
            observation: That of one episode.
            way: The way to go instead of to the target, ``(n,)``, rad or m; None for the target.
        """
        raise NotImplementedError

    def missing(self, observation: Mapping[str, FloatArray]) -> FloatArray:
        """What position and, times the lever, rotation of the tip lack, ``(6,)``, m."""
        from aicon_baselines.agents.reach.kinematics import rotation_vector, target_rotation

        robot = self.kinematics
        robot.move(observation["q"])
        position, rotation = robot.tip()
        turn = rotation_vector(
            target_rotation(self.orientation, observation, rotation) @ rotation.T
        )
        return np.concatenate((observation["target_position"] - position, self.lever * turn))

    def _step_of(self, way: FloatArray) -> FloatArray:
        """How far a step at full speed leads on a way ``(n,)``, rad or m: at most to its end."""
        excess = float(np.abs(way / (self.dt * self.kinematics.speed)).max())
        step: FloatArray = way / max(1.0, excess)
        return step

    def _fresh(self) -> RandomPlaces:
        """What is known before the first step."""
        return RandomPlaces(self.kinematics.low, self.kinematics.high, self.dt)

    def _next(self, observation: Mapping[str, FloatArray], known: RandomPlaces) -> FloatArray:
        """The velocities in one episode, toward the target or to another place."""
        if not self.places:
            return self.velocity(observation)
        cost = float(np.linalg.norm(self.missing(observation)))
        found = self.velocity(observation, known.way(observation["q"], cost))
        known.moved(float(np.abs(found / self.kinematics.speed).max()))
        return found
