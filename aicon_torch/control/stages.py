"""The stages of a control step: what each takes and gives, for whatever runs them."""

from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

from torch import Tensor

Named = Mapping[str, Tensor]
"""A group of tensors by name, such as a memory."""


class Stage(NamedTuple):
    """A part of a control step.

    Attributes:
        name: What it is called where it runs, such as in C.
        function: A function of groups of named tensors that returns others.
        takes: What the groups that it is given are called, in the order of its parameters.
        gives: What those are called that it returns.
        times: How many times in a row it runs; what it gives takes the place of what it took.
    """

    name: str
    function: Callable[..., tuple[Named, ...]]
    takes: tuple[str, ...]
    gives: tuple[str, ...]
    times: int = 1

    @property
    def varying(self) -> tuple[str, ...]:
        """What it takes that differs from time to time, where it runs several times."""
        return tuple(name for name in self.takes if name in self.gives) if self.times > 1 else ()


def run(stages: Iterable[Stage], groups: Mapping[str, Named]) -> dict[str, Named]:
    """Run stages one after the other.

    Args:
        stages: The stages.
        groups: What there is before the first, by what it is called.

    Returns:
        What there is after the last.
    """
    known = dict(groups)
    for stage in stages:
        for _ in range(stage.times):
            given = stage.function(*[known[name] for name in stage.takes])
            known.update(zip(stage.gives, given, strict=True))
    return known
