"""Compiled policies, made in the background: the readable one acts until they are there."""

import logging
import threading

from aicon_torch import Policy
from aicon_torch.resolution import Memory

_LOGGER = logging.getLogger(__name__)


class CompiledTwins:
    """For each policy of an episode the same one compiled, as soon as it is.

    Compiling takes seconds. The memory of a policy is that of its twin, so that the twin takes over
    between two steps.
    """

    def __init__(self) -> None:
        self._twins: dict[str, Policy] = {}
        self._begun: set[str] = set()

    def begin(self, name: str, policy: Policy, observation: object, memory: Memory) -> None:
        """Begin to compile a policy, unless that has begun already.

        Args:
            name: What it is called here.
            policy: The policy.
            observation: What it may see, for its first step.
            memory: A memory of it.
        """
        if name in self._begun:
            return

        self._begun.add(name)
        _LOGGER.info("Compiling the policy with %s; until then its readable step acts.", name)
        work = (name, policy, observation, memory)
        threading.Thread(target=self._compile, args=work, daemon=True).start()

    def of(self, name: str, policy: Policy) -> Policy:
        """The twin of a policy, or the policy itself where there is none yet."""
        return self._twins.get(name, policy)

    def has(self, name: str) -> bool:
        """Whether the twin is there."""
        return name in self._twins

    def _compile(self, name: str, policy: Policy, observation: object, memory: Memory) -> None:
        twin = policy.compile()
        twin.predict(observation, memory)  # type: ignore[arg-type]  # compiled at its first step
        self._twins[name] = twin
        _LOGGER.info("The policy with %s is compiled.", name)
