"""The compiled step: one control step as machine code, traced once for each size of batch."""

import logging
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress

import torch
from torch import Tensor
from torch.fx import GraphModule
from torch.fx.experimental.proxy_tensor import make_fx

from aicon_torch.control.memory import STEPS
from aicon_torch.control.step import Actions, ControlStep
from aicon_torch.resolution import Memory

_SMALL = 16
"""Products of matrices up to this size are written out: a call of a library costs more."""

Named = Mapping[str, Tensor]
"""Tensors by name, such as a memory."""

NamedFunction = Callable[..., tuple[dict[str, Tensor], ...]]
"""A function of some groups of named tensors that returns others."""

InputKind = tuple[torch.Size, torch.dtype, torch.device]
"""What a step is compiled for: shape, precision and device of the first reading."""


class CompiledStep(ControlStep):
    """A control step that does what the one it is made of does, many times faster.

    The first step with a new size of batch is traced through autograd into flat graphs of tensor
    operations, in which every gradient is written out, and TorchInductor compiles them. Where a law
    takes many gradients in a step, the descent by one of them is compiled once and called for each.
    That takes from seconds to a minute; later runs find most of it in Inductor's cache on
    disk. Observations are checked, and episodes begin, as before.

    A new precision or device is compiled by itself; where a parameter has changed, call ``compile``
    again. The step must not branch on values of tensors. Where it does, or where there is no
    compiler, it warns once and goes on uncompiled.

    Args:
        step: The step.
    """

    def __init__(self, step: ControlStep) -> None:
        super().__init__(step.model, step.backward, step.law)
        self._steps: dict[InputKind, NamedFunction] = {}
        self._compiles = True

    def __call__(self, readings: Mapping[str, Tensor], memory: Memory) -> tuple[Actions, Memory]:
        """One step: see :class:`ControlStep`."""
        if not self._compiles:
            return super().__call__(readings, memory)

        first = next(iter(readings.values()))
        kind = (first.shape, first.dtype, first.device)
        if kind not in self._steps:
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")  # torch on its own future
                    self._steps[kind] = _compile_step(self, readings, memory)
            except Exception as error:  # noqa: BLE001  # the robot goes on
                self._give_up(error)
                return super().__call__(readings, memory)

        with torch.no_grad():
            commands, new_memory = self._steps[kind](readings, memory)
        return commands, new_memory

    def _give_up(self, error: Exception) -> None:
        self._compiles = False
        warnings.warn(
            f"The policy runs uncompiled, more slowly: {_summary(error)}. Compiling needs a C++ "
            "compiler (Debian: apt install g++) and a step that does not branch on values of "
            "tensors.",
            RuntimeWarning,
            stacklevel=4,
        )


def _compile_step(step: ControlStep, readings: Named, memory: Named) -> NamedFunction:
    """A control step from readings and memory to commands and memory, compiled for this size."""
    if step.law.iterations > 1:
        return _IteratedStep(step, readings, memory)

    def whole(readings: Named, memory: Memory) -> tuple[dict[str, Tensor], ...]:
        return ControlStep.__call__(step, readings, memory)

    return _compiled(whole, readings, memory)


class _IteratedStep:
    """A control step of many gradients, of which one descent is compiled and called for each.

    Args:
        step: The step.
        readings: Readings of this size.
        memory: A memory of this size.
    """

    def __init__(self, step: ControlStep, readings: Named, memory: Named) -> None:
        self.counts: list[Named] = []
        for count in range(1, step.law.iterations + 1):
            self.counts.append({"count": step.model.like.new_tensor(count)})

        def begin(readings: Named, memory: Memory) -> tuple[dict[str, Tensor], ...]:
            values, costs = step.estimate(readings, memory)
            return values, costs, step.start(values, memory[STEPS])

        def descend(
            values: Named, costs: dict[str, Tensor], memory: Memory, actions: Actions, count: Named
        ) -> tuple[dict[str, Tensor], ...]:
            return step.descend(values, costs, memory, actions, count["count"])

        # Each is traced on what the one before it returns.
        with torch.no_grad():
            self.begin = _compiled(begin, readings, memory)
            values, costs, actions = self.begin(readings, memory)

            inputs = (values, costs, memory, actions, self.counts[0])
            self.descend = _compiled(descend, *inputs)
            actions, resolved = self.descend(*inputs)
            self.finish = _compiled(step.finish, values, memory, actions, resolved)

    def __call__(self, readings: Named, memory: Named) -> tuple[dict[str, Tensor], ...]:
        values, costs, actions = self.begin(readings, memory)
        resolved: dict[str, Tensor] = {}
        for count in self.counts:
            actions, resolved = self.descend(values, costs, memory, actions, count)
        return self.finish(values, memory, actions, resolved)


def _compiled(function: NamedFunction, *groups: Named) -> NamedFunction:
    """A function of groups of named tensors, compiled for groups like these."""
    input_names = [tuple(group) for group in groups]
    output_names: list[tuple[str, ...]] = []

    def of_list(*values: Tensor) -> tuple[Tensor, ...]:
        given, start = [], 0
        for names in input_names:
            given.append(dict(zip(names, values[start : start + len(names)], strict=True)))
            start += len(names)
        returned = function(*given)
        output_names[:] = [tuple(group) for group in returned]
        return tuple(value for group in returned for value in group.values())

    # Trace it through autograd into one flat graph of what it uses.
    keys = [(index, name) for index, names in enumerate(input_names) for name in names]
    examples = [
        groups[index][name].clone(memory_format=torch.contiguous_format) for index, name in keys
    ]  # clones: twice the same tensor would be taken for one
    graph, used = _traced(of_list, examples)
    keys = [keys[index] for index in used]
    run = _compile_graph(graph, [examples[index] for index in used])

    def call(*groups: Named) -> tuple[dict[str, Tensor], ...]:
        flat = iter(run(*[groups[index][name].contiguous() for index, name in keys]))
        return tuple({name: next(flat) for name in names} for names in output_names)

    return call


def _traced(
    function: Callable[..., tuple[Tensor, ...]], examples: Sequence[Tensor]
) -> tuple[GraphModule, list[int]]:
    """The graph of a function of tensors, and which of these it uses."""
    decompositions = {
        torch.ops.aten.mm.default: _written_out,
        torch.ops.aten.bmm.default: _written_out,
    }
    graph = make_fx(function, decompositions)(*examples)
    graph.graph.eliminate_dead_code()

    used: list[int] = []
    inputs = [node for node in graph.graph.nodes if node.op == "placeholder"]
    for index, node in enumerate(inputs):
        if node.users:
            used.append(index)
        else:
            graph.graph.erase_node(node)
    graph.recompile()
    return graph, used


def _compile_graph(
    graph: GraphModule, examples: Sequence[Tensor]
) -> Callable[..., Sequence[Tensor]]:
    """Compile a flat graph by TorchInductor."""
    # Calls from C++ are a third cheaper than from Python; torch 2.10 cannot make them.
    if all(example.device.type == "cpu" for example in examples):
        with suppress(Exception):
            return _inductor(graph, examples, cpp_wrapper=True)
    return _inductor(graph, examples, cpp_wrapper=False)


def _inductor(
    graph: GraphModule, examples: Sequence[Tensor], cpp_wrapper: bool
) -> Callable[..., Sequence[Tensor]]:
    from torch._inductor import config, standalone_compile  # takes a second to load

    # On the CPU torch 2.10 computes wrong ranks and cosines of batches with vector instructions.
    with (
        torch.no_grad(),
        config.patch({"cpp_wrapper": cpp_wrapper, "cpp.simdlen": 1}),
        _quiet("torch._inductor.ir"),
    ):
        compiled: Callable[..., Sequence[Tensor]] = standalone_compile(
            graph, [*examples], dynamic_shapes="from_example_inputs"
        )
    return compiled


@contextmanager
def _quiet(name: str) -> Iterator[None]:
    """Leave out a logger's warnings: for which operations it has no shortcut concerns no user."""
    logger = logging.getLogger(name)
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        yield
    finally:
        logger.setLevel(level)


def _written_out(first: Tensor, second: Tensor) -> Tensor:
    """``(..., n, k)`` times ``(..., k, m)``, as a sum that is compiled with what is around it."""
    if max(*first.shape[-2:], *second.shape[-2:]) > _SMALL:
        return NotImplemented  # type: ignore[no-any-return]  # it stays a call
    product: Tensor = (first.unsqueeze(-1) * second.unsqueeze(-3)).sum(-2)
    return product


def _summary(error: Exception) -> str:
    lines = str(error).strip().splitlines()
    return f"{type(error).__name__}: {lines[0] if lines else 'no message'}"
