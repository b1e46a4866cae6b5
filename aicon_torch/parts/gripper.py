"""A gripper: an actuator of its own, whose opening follows from what it was told."""

import torch
from torch import Tensor

from aicon_torch.errors import OptionError
from aicon_torch.estimation import Estimator
from aicon_torch.interconnections import Interconnection, Values
from aicon_torch.quantities import Actuator
from aicon_torch.shaping import straight_through
from aicon_torch.validation import check_positive, numbers


class Gripper(Estimator):
    """x_opening: how far apart two fingers are, from the rate at which they were told to move.

    o ← clip(o + u dt), where u is the actuator's rate, m/s; no reading is needed. Its gradient goes
    on beyond the ends, so that a gripper at an end can still be steered.

    Args:
        narrowest: Least opening, m; less than the width of what is held, so that it is pressed.
        widest: Largest opening, m.
        speed: Largest rate, m/s; the fingers follow a command that moves no faster.
        first: Opening at the beginning, m; by default the narrowest.

    Raises:
        OptionError: If the openings are not in order, or the speed is not positive.

    Example:
        >>> gripper = Gripper(narrowest=0.02, widest=0.12, speed=0.3)
        >>> WorldModel(actuators={"jaw": gripper.actuator()}, estimators=[gripper, ...], ...)
    """

    outputs = ("x_opening",)

    start: Tensor

    def __init__(
        self,
        narrowest: float,
        widest: float,
        speed: float,
        first: float | None = None,
    ) -> None:
        super().__init__()
        first = narrowest if first is None else first
        for name, opening in (("narrowest", narrowest), ("first", first), ("widest", widest)):
            numbers(name, opening, 1)
        if not 0 <= narrowest <= first <= widest or narrowest == widest:
            raise OptionError(
                f"narrowest={narrowest!r}, first={first!r}, widest={widest!r}: expected "
                "0 <= narrowest <= first <= widest, and a range (m)."
            )
        self.narrowest, self.widest, self.speed = narrowest, widest, speed
        check_positive(self, ("speed",))

        # Its own last value, the rate that it was told, and for how long.
        self.inputs = ("x_opening", "jaw", "dt")
        self.register_buffer("start", torch.tensor([first]))

    @property
    def range(self) -> float:
        """From the narrowest opening to the widest, m."""
        return self.widest - self.narrowest

    def actuator(self) -> Actuator:
        """The rate of opening, m/s, which is sent as the opening to go to, 0 closed to 1 widest."""

        def target(rate: Tensor, x_opening: Tensor, dt: Tensor) -> Tensor:
            return (x_opening + rate * dt) / self.widest

        command = Interconnection(target, inputs=["jaw", "x_opening", "dt"])
        return Actuator(1, "m/s", limit=self.speed, command=command, command_range=(0.0, 1.0))

    def initial(self, values: Values) -> dict[str, Tensor]:
        """The opening at the beginning."""
        return {"x_opening": self.start}

    @torch.no_grad()
    def update(self, values: Values) -> dict[str, Tensor]:
        """The opening ``(*B, 1)`` after the last action, m."""
        return {"x_opening": self(values, "x_opening")}

    def forward(self, values: Values, output: str) -> Tensor:
        """The opening ``(*B, 1)`` that the action brings, m."""
        opening = values["x_opening"] + values["jaw"] * values["dt"]
        within = opening.clamp(min=self.narrowest).clamp(max=self.widest)
        return straight_through(within, opening)
