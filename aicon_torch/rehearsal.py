"""Rehearsal: before a policy takes one of several ways, all of them are tried on a model."""

from collections.abc import Callable, Mapping
from typing import Any

import torch
from numpy.typing import ArrayLike
from torch import Tensor

from aicon_torch.control.memory import STEPS, starting_rows
from aicon_torch.errors import OptionError
from aicon_torch.inspection.explanation import Explanation
from aicon_torch.inspection.trace import StepTrace
from aicon_torch.policy import Policy
from aicon_torch.readings.observation import as_it_is
from aicon_torch.resolution import Memory
from aicon_torch.validation import check_count, check_function, check_instance, numbers
from aicon_torch.ways import Ways, WaysAlong

Readings = Mapping[str, Tensor]


class Rehearsal:
    """A policy that tries several ways on a model where there is a choice, and takes the best one.

    At a choice the same policy is first run on a model, from where it is, along each way, side by
    side. It takes the way that arrives in the fewest steps, or, where none arrives, the one that
    comes nearest.

    - :class:`aicon_torch.ways.WaysAlong`: exploration goes on as the quantity moved before (Sect.
      "Escaping Local Minima"), however far around that leads; the others are to turn around, and
      to explore no longer.
    - :class:`aicon_torch.ways.OtherPlaces`: an arm that obstacles hold up goes to one place after
      the other; each way begins with another one.

    It anticipates, which the paper's policy does not: it is an option that none of the shipped
    policies uses. What happens after the model's first error is up to the law, which acts
    on true readings as ever.

    It is a policy like any other, whose memory is that of the one within.

    Args:
        policy: The policy. Compile it: it takes hundreds of steps where it decides.
        imagine: The readings after a step, of the readings before it, ``(*B, size)`` each, and of
            the memory that the policy returned then, which has its action in the unit of the
            actuator. NaN is no reading; what else an observation has stays as it is.
        cost: Of the memory that the policy returns, which has readings and estimates, ``(*B,)``:
            how far they are from what is wanted.
        enough: The cost at which it has arrived.
        steps: How many steps it looks ahead at most.
        ways: What it chooses among; the ways along the nullspace by default.
        rounds: How often it looks for a way that arrives before it takes the one that comes
            nearest.

    Raises:
        OptionError: If it looks no step ahead, there are no ways to decide among, or an argument is
            something else.

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
        cost: Callable[[Mapping[str, Tensor]], Tensor],
        enough: float,
        steps: int = 1000,
        ways: Ways | None = None,
        rounds: int = 1,
    ) -> None:
        self.policy, self.imagine, self.cost = policy, imagine, cost
        self.enough, self.steps, self.rounds = numbers("enough", enough, 1)[0], steps, rounds
        check_instance(self, ("policy",), Policy, "make_policy('nav2d')")
        check_function(self, ("imagine",), "(readings, memory)")
        check_function(self, ("cost",), "(memory)")
        check_count(self, ("steps", "rounds"), least=1)

        self.ways = WaysAlong(policy) if ways is None else ways
        if isinstance(ways, type):  # which has the methods of its instances
            raise OptionError(f"ways={ways!r}: expected an instance, {ways.__name__}(policy).")
        check_instance(self, ("ways",), Ways, "WaysAlong(policy)")

    def predict(
        self,
        observation: Mapping[str, Any],
        state: Memory | None = None,
        episode_start: ArrayLike | Tensor | None = None,
        deterministic: bool = True,
    ) -> tuple[Any, Memory]:
        """One control step, with the signature of stable-baselines3: see :class:`Policy`."""
        action, memory = self.policy.predict(observation, state, episode_start, deterministic)
        batch = tuple(memory[STEPS].shape)
        starts = starting_rows(episode_start, batch, self.policy.model.like.device)
        begins = self.ways.begins(memory, state, starts)
        if begins.any():
            memory = self._better_way(observation, memory, begins)
        return action, memory

    def trace(self, memory: Memory) -> StepTrace:
        """What the step that returned this memory knew and decided."""
        return self.policy.trace(memory)

    def explain(self, memory: Memory, row: int | tuple[int, ...] = ()) -> Explanation:
        """What the step that returned this memory decided, in numbers to read."""
        return self.policy.explain(memory, row)

    def _better_way(self, observation: Mapping[str, Any], memory: Memory, begins: Tensor) -> Memory:
        """The memory, which goes on along the best way in the rows where there is a choice."""
        after = {name: value.clone() for name, value in memory.items()}
        fewest = torch.full_like(begins, torch.inf, dtype=torch.float64)

        # What is said of all rows at once is the same on every way.
        rows = _rows(observation, tuple(begins.shape))
        shared = {name: value for name, value in observation.items() if name not in rows}

        # Where a way arrives no other one is looked for.
        seeking = begins
        for number in range(self.rounds):
            seen = {name: value[seeking] for name, value in rows.items()}
            ways = self.ways.of({name: value[seeking] for name, value in memory.items()}, number)
            steps, which = self._rehearse(seen, shared, ways).min(0)

            is_better = torch.zeros_like(seeking)
            is_better[seeking] = steps < fewest[seeking]
            better = is_better[seeking].nonzero().squeeze(-1)
            for name, value in ways.items():
                after[name][is_better] = value[which[better], better]

            fewest[is_better] = steps[better]
            seeking = begins & (fewest > self.steps)
            if not seeking.any():
                break
        return after

    def _rehearse(self, seen: Readings, shared: Mapping[str, Any], memory: Memory) -> Tensor:
        """In how many steps each of the ways arrives, ``(k, n)``; fewer are better.

        One that does not arrive counts as a step more than all that there are, and a share of
        another that grows with how far off it stayed.

        Args:
            seen: What is read where there is a choice, ``(n, size)``.
            shared: What else the observation has.
            memory: The memories with which the ways begin, ``(k, n, …)``.
        """
        count = len(next(iter(memory.values())))
        readings: Readings = {name: torch.stack([value] * count) for name, value in seen.items()}
        nearest = torch.full_like(memory[STEPS], torch.inf, dtype=torch.float64)
        arrived = torch.full_like(nearest, torch.inf)

        # Of the rows that go on, those where a way has arrived are no longer tried.
        going = torch.arange(nearest.shape[-1], device=nearest.device)
        for step in range(self.steps + 1):
            cost = self._cost_of(memory).to(nearest)
            nearest[:, going] = torch.fmin(nearest[:, going], cost)  # NaN is no cost
            arrives = cost <= self.enough
            arrived[:, going] = torch.where(arrives, step, arrived[:, going])
            goes_on = ~arrives.any(0)
            if step == self.steps or not goes_on.any():
                break
            if not goes_on.all():
                going = going[goes_on]
                readings = {name: value[:, goes_on] for name, value in readings.items()}
                memory = {name: value[:, goes_on] for name, value in memory.items()}
            imagined = self.imagine({**shared, **readings}, memory)
            _, memory = self.policy.predict(imagined, memory)
            readings = {name: value for name, value in imagined.items() if name not in shared}
        off = nearest - self.enough
        share = (off / (1.0 + off)).nan_to_num(1.0)  # which it comes to as it grows
        return torch.where(arrived.isfinite(), arrived, self.steps + 1 + share)

    def _cost_of(self, memory: Memory) -> Tensor:
        """The cost of each row, ``(k, n)``.

        Raises:
            OptionError: If it is none.
        """
        cost: Any = self.cost(memory)
        expected = tuple(memory[STEPS].shape)
        if not isinstance(cost, Tensor) or tuple(cost.shape) != expected:
            got = tuple(cost.shape) if isinstance(cost, Tensor) else repr(cost)
            raise OptionError(f"cost: expected a number for each row, {expected}, got {got}.")
        return cost


def _rows(observation: Mapping[str, Any], batch: tuple[int, ...]) -> dict[str, Tensor]:
    """What of an observation is numbers for each row, ``(*B, …)``, NaN where a mask is."""
    rows: dict[str, Tensor] = {}
    for name, value in observation.items():
        found = as_it_is(name, value)
        if found is not None and tuple(found.shape[: len(batch)]) == batch:
            rows[name] = found
    return rows
