"""An approach: once held up, a hand comes to its target along the axis of its tool."""

from dataclasses import dataclass

import torch
from torch import Tensor

from aicon_torch.differentiation import stop, values_only
from aicon_torch.errors import OptionError
from aicon_torch.estimation import Estimator
from aicon_torch.interconnections import Values
from aicon_torch.parts.chain import Chain
from aicon_torch.parts.pose_reach import PoseReach
from aicon_torch.parts.tip_pose import TipPose
from aicon_torch.quantities import as_number

LOWER = 0.97
"""Share of what was missing below which it counts as less."""

PATIENCE = 0.45
"""The way that a joint at its limit goes until a tip that comes no nearer is held up, rad."""

FAR = 1e3
"""Where a target is that there was not, m."""

JUMP = 0.1
"""A target that moves by more than this in a step is another one, m."""


@dataclass(frozen=True)
class ToolAxis:
    """How much an advance along the axis of the tool counts on the way to a target.

    With the error e = p* − p of the tip and the axis z* that the tool has at the target, the tip
    has to advance by a = e·z*, and is l = ‖e − a z*‖ beside the axis. Where a > 0 the part of a
    gradient along z* counts

        g = 1/(1 + (l/r)²)

    times as much: a hand beside the opening of a shelf comes in front of it first.

    Attributes:
        pose: What x_ee and its target are; its axis is that of the tool.
        within: r, m.

    Raises:
        OptionError: If the orientation is free, or the distance is not positive.
    """

    pose: TipPose
    within: float

    def __post_init__(self) -> None:
        """Check the options."""
        if self.pose.orientation == "free":
            raise OptionError(
                "pose: its orientation is free, so its target has no axis; expected 'axis' or "
                "'full'."
            )
        if not as_number(self.within) > 0:
            raise OptionError(f"within={self.within!r}: expected a distance > 0 (m).")

    def gated(self, gradient: Tensor, x_ee: Tensor, x_target: Tensor) -> Tensor:
        """A gradient ``(*B, k)`` of x_ee as its advance counts, from the tip to its target."""
        axis, error = self.pose.axis_of(x_target), x_target[..., :3] - x_ee[..., :3]
        advance = (error * axis).sum(-1, keepdim=True)
        beside = (error - advance * axis) / self.within
        share = 1.0 / (1.0 + (beside * beside).sum(-1, keepdim=True))
        share = torch.where(advance > 0, share, 1.0)

        of_place, of_turns = gradient[..., :3], gradient[..., 3:]
        along = (of_place * axis).sum(-1, keepdim=True)
        return torch.cat((of_place - (1.0 - share) * along * axis, of_turns), dim=-1)


class Approach(Estimator):
    """x_approach: whether the direct way to a target has been found closed.

    It has once what is missing to the pose has not become less by 3 % for a while, and is open
    again where the target is another one. Its components are whether it is closed, 1 or 0, for how
    long the tip has come no nearer, s, what was missing then, m, and where the target was, m:
    ``(*B, 6)``. No gradient goes through it.

    Args:
        chain: From the joints to the tip.
        pose: What its target is.
        speed: Typical largest speed of a joint, rad/s: faster arms are less patient.

    Raises:
        OptionError: If the speed is not positive.
    """

    outputs = ("x_approach",)
    inputs = ("x_approach", "x_joints", "x_target", "dt")

    unknown: Tensor

    def __init__(self, chain: Chain, pose: TipPose, speed: float) -> None:
        super().__init__()
        if not as_number(speed) > 0:
            raise OptionError(f"speed={speed!r}: expected a number > 0 (rad/s).")
        self.chain, self.pose, self.patience = chain, pose, PATIENCE / speed
        self.missing = PoseReach(pose)
        self.register_buffer("unknown", torch.tensor([0.0, 0.0, 0.0, FAR, FAR, FAR]))

    def initial(self, values: Values) -> dict[str, Tensor]:
        """It is open, and the target is another one."""
        return {"x_approach": self.unknown}

    @values_only
    def update(self, values: Values) -> dict[str, Tensor]:
        """What has become of the tip in this step."""
        closed, waited, least, place = torch.split(values["x_approach"], [1, 1, 1, 3], dim=-1)
        x_target = values["x_target"]
        x_ee = self.pose.of_frame(self.chain(values["x_joints"]))
        missing = self.missing(x_ee, x_target).unsqueeze(-1)

        # Another target may be open.
        target = x_target[..., :3]
        moved = torch.linalg.vector_norm(target - place, dim=-1, keepdim=True)
        is_other = moved > JUMP

        # Held up is a tip that comes no nearer for a while.
        is_less = is_other | (missing < LOWER * least)
        waited = torch.where(is_less, 0.0, waited + values["dt"])
        is_closed = ((closed > 0.5) & ~is_other) | (waited >= self.patience)
        closed = is_closed.to(missing)
        least = torch.where(is_less, missing, least)
        return {"x_approach": torch.cat((closed, waited, least, target), dim=-1)}

    def forward(self, values: Values, output: str) -> Tensor:
        """What is known stays."""
        return stop(values[output])
