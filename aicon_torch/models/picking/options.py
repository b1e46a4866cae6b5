"""What is told of a hand and of blocks, what is set by hand, and what else a world may hold."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from torch import Tensor

from aicon_torch.control import ActionLaw, Foresight
from aicon_torch.errors import OptionError
from aicon_torch.estimation import Estimator
from aicon_torch.goals import Goal
from aicon_torch.parts.handle import Handle
from aicon_torch.quantities import Actuator, Sensor, as_numbers
from aicon_torch.resolution import NullspaceProjection, Resolution, SteepestPath
from aicon_torch.validation import check_positive

SIZE = 0.04
"""Width and height of a block, unless it is told otherwise, m."""


@dataclass(frozen=True)
class Hand:
    """What holds a block, and how it is told to move.

    Attributes:
        time_step: s.
        steps: How far an action of 1 moves the tip in a step: x, y and z, and where the fingers
            turn, the way of a point at the block's edge, m.
        widest: Largest opening, m.
        first: The opening at the beginning, m.
        speed: Of the opening, m/s.
        height: Of the tip above the centre of a block that is held, m.

    Raises:
        OptionError: If the time step or a step is not positive, or the steps are not 3 or 4.
    """

    time_step: float
    steps: tuple[float, ...]
    widest: float
    first: float
    speed: float
    height: float

    def __post_init__(self) -> None:
        """Check the steps."""
        check_positive(self, ("time_step",))
        given = as_numbers(self.steps)
        steps = given if isinstance(given, tuple) else ()
        if len(steps) not in (3, 4) or not all(0 < step < math.inf for step in steps):
            raise OptionError(
                f"steps={self.steps!r}: expected 3 lengths above 0 m, along x, y and z, or a 4th "
                "where the fingers turn."
            )

    def actuator(self) -> Actuator:
        """The velocity of the tip, m/s, sent as actions from −1 to 1."""

        def command(tip: Tensor) -> Tensor:
            return tip * self.time_step / tip.new_tensor(self.steps)

        speeds = tuple(step / self.time_step for step in self.steps)
        return Actuator(
            len(self.steps), "m/s", limit=speeds, command=command, command_range=(-1.0, 1.0)
        )


@dataclass(frozen=True)
class Options:
    """What is set by hand: four lengths, m; and what is known of blocks and their readings, m.

    Attributes:
        reach: From where a grasp draws, and how far it is taken to bring a block.
        rise: Of the block, at which the table holds it back no more.
        tolerance: Of the place.
        free_hand: The error of the place that an empty hand outweighs.
        noise: Deviation of the block's readings.
        size: Width of a block, and twice how high its middle rests above the table; by half of it
            the tip may be beside the block as it comes down.
        clearance: Height, from where the tip holds the block, at which nothing stands in the way;
            the size if it is not told.
        table: Height of the table, as the readings count heights.
        blocks: How many there are.
        grasp_path: Whether a place leads to the tip over the grasp that is to come as well.
        resolution: How gradients that meet are resolved.
        law: How the gradient becomes an action.
    """

    reach: float = 0.05
    rise: float = 0.055
    tolerance: float = 0.012
    free_hand: float = 0.015
    noise: float = 0.0005
    size: float = SIZE
    clearance: float | None = None
    table: float = 0.0
    blocks: int = 1
    grasp_path: bool = True
    resolution: Resolution = field(default_factory=NullspaceProjection)
    law: ActionLaw = field(default_factory=Foresight)

    @property
    def rest(self) -> float:
        """Height of the middle of a block on the table, m."""
        return self.table + self.size / 2

    @property
    def height(self) -> float:
        """How far a block is lifted that is carried, m."""
        return max(self.rise, self.clearance or 0.0)


@dataclass(frozen=True)
class Surroundings:
    """What else is in a world than blocks and a hand.

    Attributes:
        sensors: What is read of it.
        goals: What else is wanted.
        estimators: What else is known.
        moved_by: What moves the tip, where it is told otherwise than how far to go; its velocity,
            tip, is then one of the estimators.
        handles: What else can be held, by what the names of its quantities end with. Read are where
            it is, z_block, and how far from its first end, z_way; p_free, of the estimators, says
            how likely it is unlocked.
        has_drawer: Whether x_place and p_room, of the estimators, say where the block belongs and
            how likely that can be come to.
    """

    sensors: Mapping[str, Sensor] = field(default_factory=dict)
    goals: Sequence[Goal] = ()
    estimators: Sequence[Estimator] = ()
    moved_by: Mapping[str, Actuator] = field(default_factory=dict)
    handles: Mapping[str, Handle] = field(default_factory=dict)
    has_drawer: bool = False


PRESETS: Mapping[str, Mapping[str, Any]] = {
    "aicon": {},
    "without_exploration": {"resolution.exploration": None},
    "weighted_sum": {"resolution.projector": "none"},
    "steepest": {"resolution": SteepestPath()},
    "one_gradient": {"law.iterations": 1},
    "without_grasp": {"grasp_path": False},
}
"""Options by preset: ours, ours without exploration, a sum that explores, the steepest path, ours
with one gradient a step, and without the path over the grasp."""
