"""Perception: what turns raw observations, such as images, into readings before a control step."""

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from torch import Tensor


class Perception(Protocol):
    """What stands between the observation and the sensors of a graph.

    A sensor reads numbers of a fixed size. Where an observation brings something else, a perception
    makes readings of it, outside the graph: no gradient goes through it, and it keeps no state of
    its own. A network with trained weights may be one, such as
    :class:`aicon_torch.models.pusht.picture.PicturePerception`. It is neither compiled nor
    exported: it stays in Python, before the step.
    """

    def __call__(
        self,
        observation: Mapping[str, Any],
        values: Mapping[str, Tensor] | None,
        starts: NDArray[np.bool_] | None,
    ) -> Mapping[str, Any]:
        """The observation with a reading for each sensor.

        Args:
            observation: As the policy was given it.
            values: Estimates, readings and actions of the last step, by name; None before the
                first.
            starts: Rows ``(*B,)`` of the batch that begin a new episode; None if there are none.
        """
        ...


class SlowPerception(Perception, Protocol):
    """A perception in two parts, of which one may take longer than a control step.

    Called, it does both at once: ``readings(begin(...)(), observation)``. In the background the
    slow part goes on while other control steps are taken:
    :class:`aicon_torch.readings.BackgroundPerception`.
    """

    def begin(
        self,
        observation: Mapping[str, Any],
        values: Mapping[str, Tensor] | None,
        starts: NDArray[np.bool_] | None,
    ) -> Callable[[], Any] | None:
        """What is to be done about an observation; None if it brings nothing new.

        Args:
            observation: As for the whole. Whoever made it may overwrite it afterwards.
            values: As for the whole.
            starts: As for the whole.

        Returns:
            The slow part, which returns what it has seen.
        """
        ...

    def readings(
        self, seen: Any, observation: Mapping[str, Any], late: int = 0
    ) -> Mapping[str, Any]:
        """The observation with a reading for each sensor.

        Args:
            seen: What the slow part has returned; None if nothing is new.
            observation: That of this step.
            late: How many steps ago the observation came in which it was seen.
        """
        ...
