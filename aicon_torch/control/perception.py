"""Perception: what turns raw observations, such as images, into readings before a control step."""

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from torch import Tensor


class Perception(Protocol):
    """What stands between the observation and the sensors of a graph.

    A sensor reads numbers of a fixed size. Where an observation brings something else, a perception
    makes readings of it, outside the graph: no gradient goes through it, and it keeps no state of
    its own.
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
