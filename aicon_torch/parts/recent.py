"""What a sensor has read lately."""

import torch
from torch import Tensor

from aicon_torch.differentiation import stop, values_only
from aicon_torch.estimation import Estimator
from aicon_torch.interconnections import Values
from aicon_torch.validation import check_count


class Recent(Estimator):
    """The readings of a sensor in the last n steps, oldest first, ``(*B, n k)``.

    They are named after the sensor, with ``_recent``. Before the first step it read what it read
    then. No gradient goes through them.

    Args:
        sensor: Name of the sensor.
        steps: n.

    Raises:
        OptionError: If n is no whole number above 0.
    """

    def __init__(self, sensor: str, steps: int) -> None:
        super().__init__()
        self.sensor, self.steps = sensor, steps
        check_count(self, ("steps",), "number of steps", least=1)
        self.outputs = (f"{sensor}_recent",)
        self.inputs = (*self.outputs, sensor)
        self.prior_inputs = (sensor,)

    def initial(self, values: Values) -> dict[str, Tensor]:
        """The first reading, n times."""
        first = values[self.sensor]
        return {self.outputs[0]: torch.cat([first] * self.steps, dim=-1)}

    @values_only
    def update(self, values: Values) -> dict[str, Tensor]:
        """The last one comes, and the oldest goes."""
        kept, last = values[self.outputs[0]], values[self.sensor]
        return {self.outputs[0]: torch.cat((kept[..., last.shape[-1] :], last), dim=-1)}

    def forward(self, values: Values, output: str) -> Tensor:
        """What has been read stays."""
        return stop(values[output])
