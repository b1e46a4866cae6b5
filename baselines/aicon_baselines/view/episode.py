"""An episode in which one may interfere: the environment, the policy and its memory."""

import logging
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any

from gymnasium.vector import VectorEnv

from aicon_baselines.view.resolutions import carried_over, resolutions_of, with_resolution
from aicon_torch import Policy, StepTrace
from aicon_torch.inspection import QuantityTrace
from aicon_torch.resolution import Memory

ANYWHERE = "where most meet"
"""Stands for the quantity where the most gradients meet."""

_COMPILER = ThreadPoolExecutor(max_workers=1)
"""Compiles all policies: torch crashes where another thread has compiled and ended before."""

_LOGGER = logging.getLogger(__name__)


def by_seed(seed: int) -> dict[str, Any]:
    """The arguments of `reset` for an environment whose seed says everything."""
    return {"seed": [seed]}


class LiveEpisode:
    """One episode, step by step; goals, resolution and world may change between two steps.

    `info` and the memory belong to the same moment: the policy has seen the world as it is now, and
    has chosen the action of the next step.

    Args:
        name: What is watched, such as "pusht".
        env: The environment, with a single episode.
        policy: A policy of the library.
        start_arguments: The arguments of the environment's `reset` for a seed.

    Attributes:
        seed: Seed of the episode.
        steps: Number of steps taken.
        info: What the environment tells of the world as it is now; arrays with one row.
        memory: The policy's memory; its batch is (1,).
        ended: Whether the episode has ended.
        resolution: Name of the resolution in use, one of `resolutions`.
        watched: The quantity whose gradients are looked at, or `ANYWHERE`.
    """

    def __init__(
        self,
        name: str,
        env: VectorEnv[Any, Any, Any],
        policy: Policy,
        start_arguments: Callable[[int], dict[str, Any]] = by_seed,
    ) -> None:
        self.name, self.env, self.policy = name, env, policy
        self._start_arguments = start_arguments
        self._resolutions = resolutions_of(policy)
        self.resolution = next(iter(self._resolutions))
        self._compiles = False
        self._compiled: dict[str, Future[Policy]] = {}  # by resolution

        self.seed, self.steps, self.ended = 0, 0, False
        self.watched = ANYWHERE
        self.info: dict[str, Any] = {}
        self._starts = True
        self._before: Memory | None = None
        self._memory: Memory | None = None
        self._trace: StepTrace | None = None

    @property
    def memory(self) -> Memory:
        """The memory after the last step."""
        if self._memory is None:
            raise RuntimeError("the episode has not started: call start() first")
        return self._memory

    @property
    def trace(self) -> StepTrace:
        """What the policy knows and has decided, with a batch of (1,), read off its memory."""
        if self._trace is None:
            self._trace = self.policy.trace(self.memory)
        return self._trace

    @property
    def meeting(self) -> QuantityTrace:
        """What happened at the quantity that is watched.

        Where the most gradients meet depends on the resolution: those that only choose among
        gradients need not choose before the actuator.
        """
        quantities = self.trace.quantities
        if self.watched in quantities:
            return quantities[self.watched]
        return max(quantities.values(), key=lambda quantity: len(quantity.paths))

    @property
    def time_step(self) -> float:
        """Duration of a step, s."""
        return self.policy.model.dt

    @property
    def time(self) -> float:
        """Time since the start, s."""
        return self.steps * self.time_step

    @property
    def succeeded(self) -> bool:
        """Whether the environment says that it is a success now."""
        return bool(self.info.get("is_success", [False])[0])

    @property
    def resolutions(self) -> tuple[str, ...]:
        """Names of the resolutions to choose from, the policy's own first."""
        return tuple(self._resolutions)

    @property
    def compiled(self) -> bool:
        """Whether the policy in use is compiled."""
        future = self._compiled.get(self.resolution)
        return future is not None and future.done() and future.exception() is None

    def compile(self) -> None:
        """Compile in the background, also the resolutions that are chosen later.

        It takes seconds. The memory of a policy is that of the same one compiled, which takes over
        between two steps.
        """
        self._compiles = True
        self._begin_to_compile()

    def start(self, seed: int) -> None:
        """Start the episode of a seed; goals that are switched off stay off."""
        self.seed, self.steps, self.ended = seed, 0, False
        self._observation, self.info = self.env.reset(**self._start_arguments(seed))

        # Of the memory from before only the goals' factors count.
        self._starts = True
        self._before = self._memory
        if self._before is None:
            _, self._before = self.policy.predict(self._observation)
        self._decide()

    def step(self) -> None:
        """Carry out the action that was chosen, and choose the next one."""
        if self.ended:
            return

        self._observation, _, terminated, truncated, self.info = self.env.step(self._action)
        self.steps += 1
        self.ended = bool(terminated[0] or truncated[0])

        self._starts, self._before = False, self.memory
        self._decide()

    def weigh(self, goal: str, factor: float) -> None:
        """Weight a goal, 0 for off and 1 for on, and decide again.

        Raises:
            OptionError: If there is no such goal.
        """
        self._before = self.policy.switch(self._started(), **{goal: factor})
        self._decide()

    def resolve_by(self, name: str) -> None:
        """Decide again by another resolution, and go on with it.

        Estimates stay; what was remembered of conflicts does not.

        Args:
            name: One of `resolutions`.
        """
        other = with_resolution(self.policy, self._resolutions[name])
        _, fresh = other.predict(self._observation)

        self._before = carried_over(self.policy, self._started(), fresh)
        self.policy, self.resolution = other, name
        self._decide()
        self._begin_to_compile()

    def look_at(self, name: str) -> None:
        """Look at the gradients at another quantity, or `ANYWHERE`."""
        self.watched = name

    def relocate(self, options: dict[str, Any]) -> None:
        """Set the world, not the policy: it still believes what it believed, and sees the new.

        Args:
            options: Options of the environment's `reset`.

        Raises:
            ValueError: If the environment does not accept them.
        """
        self._observation, info = self.env.reset(options=options)
        self.info, self.ended = self.info | info, False
        self._decide()

    def close(self) -> None:
        """Close the environment."""
        self.env.close()

    def _decide(self) -> None:
        """Let the policy see the world as it is and choose, from what it knew before."""
        policy = self._compiled[self.resolution].result() if self.compiled else self.policy
        starts = [True] if self._starts else None
        self._action, self._memory = policy.predict(self._observation, self._started(), starts)
        self._trace = None

    def _begin_to_compile(self) -> None:
        """Compile the policy in use, where that is wanted and has not begun."""
        name = self.resolution
        if not self._compiles or name in self._compiled:
            return

        def work(policy: Policy, observation: Any, memory: Memory) -> Policy:
            compiled = policy.compile()
            compiled.predict(observation, memory)  # at its first step it compiles
            _LOGGER.info("The policy with %s is compiled.", name)
            return compiled

        _LOGGER.info("Compiling the policy with %s; until then its readable step acts.", name)
        known = (self.policy, self._observation, self._started())
        self._compiled[name] = _COMPILER.submit(work, *known)

    def _started(self) -> Memory:
        """The memory before the step that was decided last."""
        if self._before is None:
            raise RuntimeError("the episode has not started: call start() first")
        return self._before
