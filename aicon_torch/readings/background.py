"""Perception in the background: a control step takes what is ready, and waits for nothing."""

from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from torch import Tensor

from aicon_torch.readings.perception import SlowPerception
from aicon_torch.validation import check_function


class _Task(NamedTuple):
    """What is to be seen, and the step whose observation it is of."""

    see: Callable[[], Any]
    step: int


class BackgroundPerception:
    """A perception whose slow part runs in a thread of its own.

    Each step gets the readings of what was seen since the step before, if anything was, and goes on
    by prediction otherwise. While one observation is looked at, the newest one that came meanwhile
    waits. What was seen in an episode that has ended is dropped, in all rows of the batch. Readings
    are a step old or more: a perception that tells it (``late``) as the age of its sensors
    (``age_key``) leaves it to a :class:`aicon_torch.LateEKF` to make up for it.

    When a reading arrives depends on the clock, and so does the motion: for comparisons that can be
    repeated, take the perception as it is. The background belongs to one robot, or one batch, and
    its steps come one after the other.

    Args:
        perception: The perception. What its slow part raises is raised by the step that would have
            taken the reading.

    Raises:
        OptionError: If it is not in two parts.

    Example:
        >>> camera = camera_perception(Options())
        >>> policy = load_exported("arm.so", perception=BackgroundPerception(camera))
    """

    def __init__(self, perception: SlowPerception) -> None:
        self.perception = perception
        check_function(perception, ("begin", "readings"), "(...), of a perception in two parts")
        self._thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="perception")
        self._running: tuple[Future[Any], int] | None = None
        self._waiting: _Task | None = None
        self._step = 0

    def __call__(
        self,
        observation: Mapping[str, Any],
        values: Mapping[str, Tensor] | None,
        starts: NDArray[np.bool_] | None,
    ) -> Mapping[str, Any]:
        """What is ready: see :class:`Perception`."""
        self._step += 1
        if values is None or (starts is not None and starts.any()):
            self._running = self._waiting = None

        # What has been seen by now.
        seen, late = None, 0
        if self._running is not None and self._running[0].done():
            future, step = self._running
            self._running = None
            seen, late = future.result(), self._step - step

        # What is to be seen next.
        see = self.perception.begin(observation, values, starts)
        if see is not None:
            self._waiting = _Task(see, self._step)
        if self._running is None and self._waiting is not None:
            task, self._waiting = self._waiting, None
            self._running = self._thread.submit(task.see), task.step

        return self.perception.readings(seen, observation, late)
