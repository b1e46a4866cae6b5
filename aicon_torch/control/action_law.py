"""The action law: from the gradient at an actuator to the next action."""

from typing import Protocol, runtime_checkable

import torch
from torch import Tensor

from aicon_torch.quantities import Actuator


@runtime_checkable
class ActionLaw(Protocol):
    """How the gradient at an actuator becomes its next action.

    A control step calls it so: the descent begins at :meth:`start`, :meth:`descend` takes one
    gradient after the other, and :meth:`finish` makes an action of what came out.
    """

    @property
    def iterations(self) -> int:
        """K, the number of gradients in a control step."""
        ...

    @property
    def foresees(self) -> bool:
        """Whether each gradient is taken where the model foresees that the descent so far leads.

        Otherwise all are taken at the estimates as they are.
        """
        ...

    @property
    def horizon(self) -> float | None:
        """How far ahead the model foresees, s; None for one control step."""
        ...

    def check(self, name: str, actuator: Actuator) -> None:
        """Check that the law can drive an actuator.

        Raises:
            OptionError: If not.
        """
        ...

    def start(
        self, last: Tensor, steps: Tensor, actuator: Actuator, motions: Tensor | None = None
    ) -> Tensor:
        """Where the descent begins, ``(*B, size)``.

        Args:
            last: The last action, ``(*B, size)``.
            steps: How many steps ago the episode began, ``(*B,)``.
            actuator: Whose limit holds.
            motions: Of which a dither is a mixture, ``(*B, size, k)``; None for one of each
                component.
        """
        ...

    def descend(
        self, action: Tensor, gradient: Tensor, iteration: Tensor, actuator: Actuator
    ) -> Tensor:
        """The action after one more gradient, within the actuator's limit, ``(*B, size)``.

        Args:
            action: The action so far, ``(*B, size)``.
            gradient: ∇ at the actuator, ``(*B, size)``.
            iteration: k = 1 … K, a scalar.
            actuator: Whose limit holds.
        """
        ...

    def finish(self, action: Tensor, last: Tensor, actuator: Actuator, dt: float) -> Tensor:
        """The next action ``(*B, size)``, from where the descent ended and the last action."""
        ...


def low_pass(
    action: Tensor, last: Tensor, smoothing: float, actuator: Actuator, dt: float
) -> Tensor:
    """A ← a + dt/(dt + T) (a* − a), ``(*B, size)`` (Sect. "Stabilizing the Control Signal").

    Args:
        action: a*, ``(*B, size)``.
        last: The last action a, ``(*B, size)``.
        smoothing: T, s; 0 switches it off.
        actuator: Whose limit holds.
        dt: Time step, s.
    """
    if smoothing == 0:
        return action
    return actuator.clip(torch.lerp(last, action, dt / (dt + smoothing)))
