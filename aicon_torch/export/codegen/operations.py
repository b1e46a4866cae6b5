"""Records the operations on tensors that a function runs, in order."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import torch
from torch import Tensor
from torch._ops import OpOverload
from torch.utils._python_dispatch import TorchDispatchMode

ATEN = torch.ops.aten

Decompositions = Mapping[Any, Callable[..., Any]]
"""What an operator is taken apart into."""


class Operation(NamedTuple):
    """One operation, below autograd.

    Attributes:
        operator: Which it is.
        args: Its arguments, with the tensors that it was given.
        kwargs: Those by name.
        result: What it returned: a tensor, several, or none.
    """

    operator: OpOverload
    args: tuple[Any, ...]
    kwargs: dict[str, Any]
    result: Any

    @property
    def given(self) -> Iterator[Tensor]:
        """The tensors among its arguments."""
        return _tensors((*self.args, *self.kwargs.values()))

    @property
    def returned(self) -> Iterator[Tensor]:
        """The tensors that it returned."""
        return _tensors((self.result,))


class Operations(TorchDispatchMode):
    """Notes the operations while it is entered, those of autograd's backward passes as well.

    Tensors are known by their identity, so all that are seen stay alive with it.

    Args:
        inputs: What the function is given; its course must not depend on their values.
        decompositions: What operators are taken apart into.
    """

    def __init__(self, inputs: Iterable[Tensor], decompositions: Decompositions) -> None:
        super().__init__()
        self._decompositions = decompositions
        self._noted: list[Operation] = []
        self._varying = {id(tensor) for tensor in inputs}

    def __torch_dispatch__(
        self,
        func: OpOverload,
        types: Any,
        args: tuple[Any, ...] = (),
        kwargs: dict[str, Any] | None = None,
    ) -> Any:
        """Run an operation, and note it, or what it is taken apart into."""
        kwargs = kwargs or {}

        # What it is taken apart into runs under this mode again, and is noted piece by piece.
        with self:
            parts = self._decompositions.get(func, func.decompose)(*args, **kwargs)
        if parts is not NotImplemented:
            return parts

        varies = any(id(tensor) in self._varying for tensor in _tensors((*args, *kwargs.values())))

        # item() and the like may steer the course by a constant, never by what an input changes.
        if torch.Tag.data_dependent_output in func.tags:
            if varies:
                raise RuntimeError(f"{func} asks for the value of a tensor that is not known yet.")
            return func(*args, **kwargs)

        # What torch.tensor(...) made is copied, so that nothing changes it later.
        func = ATEN.lift_fresh_copy.default if func is ATEN.lift_fresh.default else func
        operation = Operation(func, args, kwargs, func(*args, **kwargs))
        self._noted.append(operation)
        if varies:
            self._varying.update(id(tensor) for tensor in operation.returned)
        return operation.result

    def needed_for(self, results: Sequence[Tensor]) -> list[Operation]:
        """The operations without those that these results do not need.

        What changes a tensor in place, or returns nothing, is always needed.
        """
        # Who reads a tensor ran after who gave it, so one pass backward finds all.
        needed = {id(tensor) for tensor in results}
        kept: list[Operation] = []
        for operation in reversed(self._noted):
            returned = list(operation.returned)
            changes = operation.operator._schema.is_mutable or not returned
            if changes or any(id(tensor) in needed for tensor in returned):
                needed.update(id(tensor) for tensor in operation.given)
                kept.append(operation)
        return kept[::-1]


def _tensors(values: Iterable[Any]) -> Iterator[Tensor]:
    """The tensors among some values, and in lists among them."""
    for value in values:
        if isinstance(value, Tensor):
            yield value
        elif isinstance(value, list | tuple):
            yield from _tensors(value)
