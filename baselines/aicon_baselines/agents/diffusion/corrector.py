"""A student that is corrected: it acts at first, and its teacher goes on from where that led."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from aicon_baselines.evaluation.predictor import Predictor


class Corrections(NamedTuple):
    """What a corrector remembers of B episodes.

    Attributes:
        steps: Steps taken, all together.
        taught: Whether the teacher acted in the last of them, (B,).
        student: The student's memory.
        teacher: The teacher's memory.
    """

    steps: int
    taught: NDArray[np.bool_]
    student: Any
    teacher: Any


@dataclass(frozen=True)
class Corrector:
    """Lets a student act for some steps, then the teacher, which has not seen what was before.

    Attributes:
        student: The student.
        teacher: The teacher.
        until: Steps that the student acts, (B,), one or more.
    """

    student: Predictor
    teacher: Predictor
    until: NDArray[np.int64]

    def predict(
        self,
        observation: Any,
        state: Corrections | None = None,
        episode_start: NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Any, Corrections]:
        """The actions of who acts now."""
        before = state or Corrections(0, np.zeros(len(self.until), np.bool_), None, None)
        starts = np.zeros(len(self.until), np.bool_) if episode_start is None else episode_start

        # An episode of the teacher begins where that of the student ends.
        taught = before.steps >= self.until
        unaware = starts | (before.steps <= self.until)
        would, teacher = self.teacher.predict(observation, before.teacher, unaware, deterministic)

        # A student that samples is slow: it is asked for as long as it acts in any episode.
        acts, student = would, before.student
        if not taught.all():
            acts, student = self.student.predict(observation, student, starts, deterministic)

        memory = Corrections(before.steps + 1, taught, student, teacher)
        if isinstance(would, dict):
            return {part: _chosen(taught, would[part], acts[part]) for part in would}, memory
        return _chosen(taught, would, acts), memory


def _chosen(taught: NDArray[np.bool_], would: Any, acts: Any) -> Any:
    """The teacher's actions (B, n) where it teaches, else the student's."""
    return np.where(taught[:, np.newaxis], would, acts).astype(np.float32)
