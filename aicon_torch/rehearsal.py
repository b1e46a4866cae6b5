"""Rehearsal: where a conflict begins, both ways along the nullspace are tried on a model first."""

from collections.abc import Callable, Mapping
from typing import Any

import torch
from numpy.typing import ArrayLike
from torch import Tensor

from aicon_torch.control.memory import starting_rows
from aicon_torch.errors import OptionError
from aicon_torch.inspection.explanation import Explanation
from aicon_torch.inspection.trace import StepTrace
from aicon_torch.policy import Policy
from aicon_torch.resolution import Memory

EXPLORING = "/exploring"
"""How the key ends under which the memory has whether a quantity explores."""

TURNED = ("/average", "/tangent")
"""How the keys end of what says which way it goes on."""

Readings = Mapping[str, Tensor]


class Rehearsal:
    """A policy that tries both ways where it begins to explore, and goes the better one.

    Exploration goes on as the quantity moved before (Sect. "Escaping Local Minima"), however far
    around that leads. Here the same policy is first run on a model, from where it is: once as it
    is, and once with its motion turned around. It goes the way that arrives in fewer steps, or
    comes nearer where neither does.

    It anticipates, which the paper's policy does not: it is an option, and none of the policies
    that are shipped has it. What happens after the model's first error is up to the law, which acts
    on true readings as ever.

    It is a policy like any other, whose memory is that of the one within.

    Args:
        policy: The policy. Compile it: it takes hundreds of steps where a conflict begins.
        imagine: The readings after a step, of the readings before it, ``(*B, size)`` each, and of
            the memory that the policy returned then, which has its action in the unit of the
            actuator.
        cost: Of readings, ``(*B,)``: how far they are from what is wanted.
        enough: The cost at which it has arrived.
        steps: How far it looks ahead at most.

    Raises:
        OptionError: If it looks no step ahead, or the policy does not explore.

    Example:
        >>> def imagine(readings, memory):
        ...     return readings | {"z_ball": readings["z_ball"] + 0.1 * memory["a"]}
        >>> rehearsed = Rehearsal(policy.compile(), imagine, far, enough=0.1)
        >>> action, memory = rehearsed.predict(observation)
    """

    def __init__(
        self,
        policy: Policy,
        imagine: Callable[[Readings, Mapping[str, Tensor]], Readings],
        cost: Callable[[Readings], Tensor],
        enough: float,
        steps: int = 1000,
    ) -> None:
        if steps < 1:
            raise OptionError(f"steps={steps!r}: expected at least one.")
        if getattr(policy.resolution, "exploration", None) is None:
            raise OptionError("policy: it does not explore, so there is nothing to rehearse.")
        self.policy = policy
        self.imagine, self.cost, self.enough, self.steps = imagine, cost, enough, steps

    def predict(
        self,
        observation: Mapping[str, Any],
        state: Memory | None = None,
        episode_start: ArrayLike | Tensor | None = None,
        deterministic: bool = True,
    ) -> tuple[Any, Memory]:
        """One control step, with the signature of stable-baselines3: see :class:`Policy`."""
        action, memory = self.policy.predict(observation, state, episode_start, deterministic)
        begins = self._begins(memory, state, episode_start)
        if begins.any():
            memory = self._better_way(observation, memory, begins)
        return action, memory

    def trace(self, memory: Memory) -> StepTrace:
        """What the step that returned this memory knew and decided."""
        return self.policy.trace(memory)

    def explain(self, memory: Memory, row: int | tuple[int, ...] = ()) -> Explanation:
        """What the step that returned this memory decided, in numbers to read."""
        return self.policy.explain(memory, row)

    def _begins(
        self, memory: Memory, before: Memory | None, episode_start: ArrayLike | Tensor | None
    ) -> Tensor:
        """The rows ``(*B,)`` in which a quantity explores that did not in the last step."""
        names = [name for name in memory if name.endswith(EXPLORING)]
        explores = torch.stack([memory[name] for name in names])
        if before is None:
            return explores.any(0)

        explored = torch.stack([before[name] for name in names])
        starts = starting_rows(episode_start, tuple(explored.shape[1:]), explored.device)
        if starts is not None:
            explored = explored & ~starts
        return (explores & ~explored).any(0)

    def _better_way(self, observation: Mapping[str, Any], memory: Memory, begins: Tensor) -> Memory:
        """The memory, turned around in the rows in which that is the better way."""
        rows = {name: value[begins] for name, value in memory.items()}
        seen = {name: torch.as_tensor(value)[begins] for name, value in observation.items()}
        turned = {name: -value if name.endswith(TURNED) else value for name, value in rows.items()}

        both = {name: torch.stack((value, turned[name])) for name, value in rows.items()}
        readings = {name: torch.stack((value, value)) for name, value in seen.items()}
        is_better = self._rehearse(readings, both).diff(dim=0)[0] < 0

        chosen = {}
        for name, value in memory.items():
            chosen[name] = value.clone()
            other = is_better.reshape(-1, *(1,) * (rows[name].dim() - 1))
            chosen[name][begins] = torch.where(other, turned[name], rows[name])
        return chosen

    def _rehearse(self, readings: Readings, memory: Memory) -> Tensor:
        """What both ways are worth, ``(2, n)``: steps until they arrive; less is better.

        Where one does not arrive, all of the steps, and a share of another that grows with how near
        it came.
        """
        nearest = self.cost(readings)
        arrived = torch.full_like(nearest, torch.inf)
        for step in range(self.steps):
            readings = self.imagine(readings, memory)
            cost = self.cost(readings)
            nearest = torch.minimum(nearest, cost)
            arrived = torch.where(cost <= self.enough, arrived.clamp(max=step), arrived)
            if (arrived.amin(0) <= step).all():
                break
            _, memory = self.policy.predict(readings, memory)
        return torch.where(arrived.isfinite(), arrived, self.steps + nearest / (1.0 + nearest))
