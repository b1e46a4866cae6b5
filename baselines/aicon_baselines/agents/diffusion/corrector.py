"""A student that is corrected: it acts at first, and its teacher goes on from where that led."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from aicon_baselines.evaluation.predictor import Predictor
from aicon_torch import Policy, WorldModel
from aicon_torch.resolution import Memory


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
    """Lets a student act for some steps, then the teacher, who has watched and knows what was done.

    Attributes:
        student: The student.
        teacher: The teacher.
        until: Steps that the student acts, (B,), one or more.
    """

    student: Predictor
    teacher: Policy
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
        taught = before.steps >= self.until

        # A student that samples is slow: it is asked for as long as it acts in any episode.
        would, teacher = self.teacher.predict(observation, before.teacher, starts)
        if taught.all():
            return would, Corrections(before.steps + 1, taught, before.student, teacher)
        acts, student = self.student.predict(observation, before.student, starts, deterministic)

        # What the teacher knows follows from what was done, not from what it would have done.
        if isinstance(would, dict):
            sent: Any = {part: _chosen(taught, would[part], acts[part]) for part in would}
        else:
            sent = _chosen(taught, would, acts)
        teacher = teacher | actions_of(sent, self.teacher.model, teacher)
        return sent, Corrections(before.steps + 1, taught, student, teacher)


def _chosen(taught: NDArray[np.bool_], would: Any, acts: Any) -> NDArray[np.float32]:
    """The teacher's commands (B, n) where it teaches, else the student's."""
    return np.where(taught[:, np.newaxis], would, acts).astype(np.float32)


def actions_of(sent: Any, model: WorldModel, memory: Memory) -> dict[str, Tensor]:
    """Each actuator's action a (B, n), for whose command c(a) this was sent.

    a = (∂c/∂a)⁻¹ (sent - c(0)), which is exact where a command is affine in its action.

    Args:
        sent: The commands (B, n), by actuator; of a single actuator, alone.
        model: Whose actuators they are.
        memory: What was known when they were sent, of B episodes.
    """
    if not isinstance(sent, dict):
        sent = dict.fromkeys(model.actuators, sent)

    values, actions = model.values(memory), {}
    for name in model.actuators:
        target = torch.as_tensor(sent[name]).to(values[name])
        command = model.declaration.commands.get(name)
        actions[name] = target if command is None else _solved(command, name, values, target)
    return actions


def _solved(command: Any, name: str, values: dict[str, Tensor], target: Tensor) -> Tensor:
    """One step of Newton from rest, in every row."""
    # No row's command depends on another row's action, so that their sum has all derivatives.
    action = torch.zeros_like(target, requires_grad=True)
    with torch.enable_grad():
        sent: Tensor = command({**values, name: action})
        components = sent.sum(0).unbind()
        rows = [torch.autograd.grad(each, action, retain_graph=True)[0] for each in components]

    jacobian = torch.stack(rows, dim=-2)  # (B, n, n)
    solved: Tensor = torch.linalg.solve(jacobian, target - sent.detach())  # a number, no graph
    return solved
