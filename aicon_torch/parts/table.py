"""A table under an arm as a goal: a plane that no link may reach."""

from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.errors import OptionError
from aicon_torch.parts.hinge import Margin, SquaredHinge
from aicon_torch.parts.robot import Robot
from aicon_torch.parts.self_collision import CapsuleSegments
from aicon_torch.validation import numbers

SAMPLES = 1024
"""Random postures in which it is seen which links move up and down."""

LEAST_RISE = 0.01
"""Links that move by less than this, m, cannot give way to a table."""


@dataclass(frozen=True)
class Table(Margin):
    """g = w Σ max(0, 1 − dᵢ/d₀)², where dᵢ is how high a link is above the table.

    dᵢ = min(z, z') − rᵢ − h for the ends z, z' of the link's capsule and its radius rᵢ.

    Attributes:
        height: h of the table in the frame of the base, m.
        links: The numbers i of the capsules that count.
        radii: Their radii rᵢ, m.
        cost: Margin d₀ (m) and weight w.

    Example:
        >>> arm = Robot.from_urdf("so101.urdf", tip="gripper_frame_link")
        >>> Goal("table", Table.under(arm, 0.0, SquaredHinge(margin=0.01, weight=1.0)), safety=True)
    """

    height: float
    links: tuple[int, ...]
    radii: tuple[float, ...]
    cost: SquaredHinge

    @classmethod
    def under(cls, robot: Robot, height: float, cost: SquaredHinge) -> "Table":
        """A table under those links of a robot that can rise.

        Args:
            robot: The robot, with a shape.
            height: Of the table in the frame of the base, m.
            cost: Margin d₀ (m) and weight w.

        Raises:
            OptionError: If the robot has no shape, the height is no number, or a link cannot keep
                off the table.
        """
        if robot.shape is None:
            raise OptionError("robot: it has no shape, so there is nothing to keep off a table.")
        numbers("height", height, 1)
        capsules = robot.shape.capsules
        segments = CapsuleSegments(robot.chain, capsules)(robot.chain.postures(SAMPLES))
        heights = _lower_end(segments)
        highest = heights.amax(0)
        links = torch.nonzero(highest - heights.amin(0) > LEAST_RISE).flatten().tolist()
        if not links:
            raise OptionError("robot: none of its links moves up or down, so none can give way.")

        radii = tuple(capsules[link].radius for link in links)

        # What no posture can keep is no safety goal.
        for link, radius in zip(links, radii, strict=True):
            room = float(highest[link]) - radius - height
            if room < cost.margin:
                raise OptionError(
                    f"height={height!r}: {robot.shape.links[link]} gets no higher than {room:.3f} "
                    f"m above such a table, and shall keep {cost.margin} m."
                )
        return cls(height, tuple(links), radii, cost)

    def __call__(self, x_body: Tensor) -> Tensor:
        """The cost ``(*B,)`` of the segments ``(*B, C, 6)``, m."""
        return self.cost(self.distances(x_body))

    def distances(self, x_body: Tensor) -> Tensor:
        """dᵢ: how high each link is above the table, ``(*B, n)``, m; negative in it."""
        lower = _lower_end(x_body[..., list(self.links), :])
        return lower - lower.new_tensor(self.radii) - self.height


def _lower_end(segments: Tensor) -> Tensor:
    """How high the lower end of each segment ``(*B, C, 6)`` is, ``(*B, C)``, m."""
    return torch.minimum(segments[..., 2], segments[..., 5])
