"""The compiled step: one control step as machine code, traced once for each size of batch."""

import logging
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from typing import Any

import torch
from torch import Tensor
from torch.fx import GraphModule
from torch.fx.experimental.proxy_tensor import make_fx

from aicon_torch.control.stages import Named, Stage, run
from aicon_torch.control.step import Actions, ControlStep
from aicon_torch.differentiation import recorded
from aicon_torch.export.codegen.operations import noted
from aicon_torch.resolution import Memory

_SMALL = 16
"""Products of matrices up to this size are written out: a call of a library costs more."""

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
        self._compiled: dict[InputKind, list[Stage]] = {}
        self._compiles = True

    def __call__(self, readings: Named, memory: Memory) -> tuple[Actions, Memory]:
        """One step: see :class:`ControlStep`."""
        if not self._compiles:
            return super().__call__(readings, memory)

        first = next(iter(readings.values()))
        kind = (first.shape, first.dtype, first.device)
        groups = {"readings": readings, "memory": memory}
        if kind not in self._compiled:
            try:
                self._compiled[kind] = compile_stages(self.stages, groups)
            except Exception as error:  # noqa: BLE001  # the robot goes on
                self._give_up(error)
                return super().__call__(readings, memory)

        # The gradients are operations of the compiled graph: autograd has nothing to record.
        with torch.no_grad():
            after = run(self._compiled[kind], groups)
        return dict(after["commands"]), dict(after["memory"])

    def _give_up(self, error: Exception) -> None:
        self._compiles = False
        warnings.warn(
            f"The policy runs uncompiled, more slowly: {_summary(error)}. Compiling needs a C++ "
            "compiler (Debian: apt install g++) and a step that does not branch on values of "
            "tensors.",
            RuntimeWarning,
            stacklevel=4,
        )


def compile_stages(stages: Sequence[Stage], groups: Mapping[str, Named]) -> list[Stage]:
    """Stages, each compiled for what those before it give.

    Args:
        stages: The stages.
        groups: What there is before the first, of the size to compile for.
    """
    compiled: list[Stage] = []
    with torch.no_grad(), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # torch on its own future
        for stage in stages:
            function = _CompiledFunction(stage, [groups[name] for name in stage.takes])
            compiled.append(stage._replace(function=function))
            groups = run([compiled[-1]._replace(times=1)], groups)
    return compiled


class _CompiledFunction:
    """A function of groups of named tensors, compiled: it is given those that it uses in one list.

    Args:
        stage: The stage whose function it is.
        groups: Groups of the size to compile for.
    """

    def __init__(self, stage: Stage, groups: Sequence[Named]) -> None:
        self._gives: list[tuple[str, ...]] = []  # the names in each group that it returns

        # In one list stand the tensors of all groups, each under its place: its group and its name.
        places = [(index, name) for index, group in enumerate(groups) for name in group]
        examples = [groups[index][name] for index, name in places]

        def of_list(*listed: Tensor) -> tuple[Tensor, ...]:
            given: list[dict[str, Tensor]] = [{} for _ in groups]
            for (index, name), value in zip(places, listed, strict=True):
                given[index][name] = value
            returned = stage.function(*given)
            self._gives = [tuple(group) for group in returned]
            return tuple(value for group in returned for value in group.values())

        # Twice the same tensor would be taken for one.
        examples = [example.clone(memory_format=torch.contiguous_format) for example in examples]
        graph, used = _traced(of_list, examples)
        self._takes = [places[index] for index in used]
        self._run = _compile_graph(graph, [examples[index] for index in used])

    def __call__(self, *groups: Named) -> tuple[Named, ...]:
        """What the function returns."""
        listed = [groups[index][name].contiguous() for index, name in self._takes]
        values = iter(self._run(*listed))
        return tuple({name: next(values) for name in names} for names in self._gives)


def _traced(
    function: Callable[..., tuple[Tensor, ...]], examples: Sequence[Tensor]
) -> tuple[GraphModule, list[int]]:
    """The graph of a function of tensors, and which of these it uses."""
    # Numbers that are read in numpy, or counted, would be constants of the graph: an error here.
    noted(function, examples, {})

    # Small products are written out, so that they are fused with what surrounds them. So is the
    # gradient of a selection: fused, torch 2.10 reads its sum before anything is added to it.
    decompositions: dict[Any, Callable[..., Tensor]] = {
        torch.ops.aten.mm.default: _written_out,
        torch.ops.aten.bmm.default: _written_out,
        torch.ops.aten.scatter_add.default: _scattered,
    }
    with recorded():
        graph = make_fx(function, decompositions)(*examples)
    graph.graph.eliminate_dead_code()

    # Inputs that nothing reads are not asked for.
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


def _scattered(start: Tensor, dim: int, index: Tensor, source: Tensor) -> Tensor:
    """Σ of what is selected for each place, added to what is there: along the last dimension."""
    last = start.dim() - 1
    if dim % start.dim() != last or start.shape[:-1] != index.shape[:-1]:
        return NotImplemented  # type: ignore[no-any-return]  # it stays a call
    places = torch.arange(start.shape[-1], device=start.device)
    is_here = index.unsqueeze(-1) == places
    source = source[..., : index.shape[-1]].unsqueeze(-1)
    return start + torch.where(is_here, source, 0.0).sum(-2)
