"""Records the operations on tensors that a function runs, in order."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import torch
from torch import Tensor
from torch._ops import OpOverload
from torch.overrides import TorchFunctionMode
from torch.utils._python_dispatch import TorchDispatchMode

from aicon_torch.differentiation import recorded
from aicon_torch.errors import GraphError

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


UNSEEN = (Tensor.numpy, Tensor.tolist, Tensor.__array__)
"""What reads a tensor without an operation."""


class UnknownValueError(GraphError, RuntimeError):
    """A function asks for the value of a tensor that is known only when its translation runs."""

    def __init__(self, by: str) -> None:
        super().__init__(
            f"{by} asks for the value of a tensor that is known only when the step runs: expected "
            "torch.where, gather or index_select, not if, item(), numpy(), a mask as an index, or "
            "an index without dimensions."
        )


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
        self._varying = set(map(_storage, inputs))  # what these are in; a view is where its base is

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

        # item() and the like may steer the course by a constant, never by what an input changes.
        asked = _asked_by(func, args)
        if self.vary(asked):
            raise UnknownValueError(str(func))
        if torch.Tag.data_dependent_output in func.tags:
            return func(*args, **kwargs)

        # What torch.tensor(...) made is copied, so that nothing changes it later.
        func = ATEN.lift_fresh_copy.default if func is ATEN.lift_fresh.default else func
        # An operator of ours may compute in numpy. (torch leaves what allows it untyped.)
        with torch._C.DisableTorchFunction():  # type: ignore[no-untyped-call]
            operation = Operation(func, args, kwargs, func(*args, **kwargs))
        self._noted.append(operation)
        if self.vary(operation.given):
            self._varying.update(map(_storage, operation.returned))
        return operation.result

    def vary(self, tensors: Iterable[Tensor]) -> bool:
        """Whether an input changes any of these tensors."""
        return any(_storage(tensor) in self._varying for tensor in tensors)

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


def noted(
    function: Callable[..., Any], inputs: Sequence[Tensor], decompositions: Decompositions
) -> tuple[Operations, Any]:
    """The operations that a function runs, once, and what it returns.

    Args:
        function: The function.
        inputs: What it is given; its course must not depend on their values.
        decompositions: What operators are taken apart into.

    Raises:
        UnknownValueError: If its course depends on them all the same.
    """
    operations = Operations(inputs, decompositions)
    with operations, _Reading(operations), recorded():
        return operations, function(*inputs)


class _Reading(TorchFunctionMode):
    """Sees to it that nothing reads what an input changes otherwise than by an operation.

    Args:
        operations: What is noted meanwhile.
    """

    def __init__(self, operations: Operations) -> None:
        super().__init__()
        self._operations = operations

    def __torch_function__(
        self,
        func: Any,
        types: Any,
        args: tuple[Any, ...] = (),
        kwargs: dict[str, Any] | None = None,
    ) -> Any:
        """Run a function of torch's, unless it is one of those."""
        if func in UNSEEN and self._operations.vary(_tensors(args)):
            raise UnknownValueError(f"Tensor.{func.__name__}")
        return func(*args, **(kwargs or {}))


def _tensors(values: Iterable[Any]) -> Iterator[Tensor]:
    """The tensors among some values, and in lists among them."""
    for value in values:
        if isinstance(value, Tensor):
            yield value
        elif isinstance(value, list | tuple):
            yield from _tensors(value)


def _storage(tensor: Tensor) -> int:
    """What tells one storage from another."""
    return int(tensor.untyped_storage()._cdata)


def _asked_by(operator: OpOverload, args: Iterable[Any]) -> list[Tensor]:
    """The tensors whose values say what an operator returns in Python, or of which shape."""
    if operator is ATEN.index.Tensor:  # by a mask; where indices lead, the shape is theirs
        _, indices = args
        return [index for index in _tensors(indices) if index.dtype in (torch.bool, torch.uint8)]
    asks = {torch.Tag.data_dependent_output, torch.Tag.dynamic_output_shape}
    return [] if asks.isdisjoint(operator.tags) else list(_tensors(args))
