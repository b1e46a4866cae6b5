"""The compiled step: one control step as machine code, traced once for each size of batch."""

import logging
import warnings
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress

import torch
from torch import Tensor
from torch.fx import GraphModule
from torch.fx.experimental.proxy_tensor import make_fx

from aicon_torch.control.step import ControlStep
from aicon_torch.resolution import Memory

_SMALL = 16
"""Products of matrices up to this size are written out: a call of a library costs more."""

CompiledFunction = Callable[..., Sequence[Tensor]]
"""From the values of readings and memory to those of commands and memory, each in a fixed order."""

InputKind = tuple[torch.Size, torch.dtype, torch.device]
"""What a function is compiled for: shape, precision and device of the first reading."""


class CompiledStep(ControlStep):
    """A control step that does what the one it is made of does, many times faster.

    The first step with a new size of batch is traced through autograd into one flat graph of tensor
    operations, in which every gradient is written out, and TorchInductor compiles it. That takes
    from seconds to a minute; later runs find most of it in Inductor's cache on disk. Observations
    are checked, and episodes begin, as before.

    A new precision or device is compiled by itself; where a parameter has changed, call ``compile``
    again. The step must not branch on values of tensors. Where it does, or where there is no
    compiler, it warns once and goes on uncompiled.

    Args:
        step: The step.
        memory_keys: The keys of its memory.
    """

    def __init__(self, step: ControlStep, memory_keys: Collection[str]) -> None:
        super().__init__(step.model, step.backward, step.law)
        self._memory_order = tuple(sorted(memory_keys))
        self._functions: dict[InputKind, CompiledFunction] = {}
        self._compiles = True

    def __call__(
        self, readings: Mapping[str, Tensor], memory: Memory
    ) -> tuple[dict[str, Tensor], Memory]:
        """One step: see :class:`ControlStep`."""
        if not self._compiles:
            return super().__call__(readings, memory)

        # Dictionaries become lists in a fixed order.
        names = sorted(readings)
        inputs = [readings[name].contiguous() for name in names]
        inputs += [memory[key].contiguous() for key in self._memory_order]

        kind = (inputs[0].shape, inputs[0].dtype, inputs[0].device)
        if kind not in self._functions:
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")  # torch on its own future
                    self._functions[kind] = self._compile(names, inputs)
            except Exception as error:  # noqa: BLE001  # the robot goes on
                self._give_up(error)
                return super().__call__(readings, memory)

        with torch.no_grad():
            outputs = self._functions[kind](*inputs)
        return self._as_dictionaries(outputs)

    def _as_dictionaries(self, outputs: Sequence[Tensor]) -> tuple[dict[str, Tensor], Memory]:
        """Commands by actuator and the memory, from the values in their order."""
        actuators = list(self.model.actuators)
        commands = dict(zip(actuators, outputs[: len(actuators)], strict=True))
        memory = dict(zip(self._memory_order, outputs[len(actuators) :], strict=True))
        return commands, memory

    def _give_up(self, error: Exception) -> None:
        self._compiles = False
        warnings.warn(
            f"The policy runs uncompiled, more slowly: {_summary(error)}. Compiling needs a C++ "
            "compiler (Debian: apt install g++) and a step that does not branch on values of "
            "tensors.",
            RuntimeWarning,
            stacklevel=4,
        )

    def _compile(self, names: Sequence[str], inputs: Sequence[Tensor]) -> CompiledFunction:
        """The step for inputs of these shapes."""

        def flat_step(*values: Tensor) -> tuple[Tensor, ...]:
            readings = dict(zip(names, values, strict=False))
            memory = dict(zip(self._memory_order, values[len(names) :], strict=True))
            commands, memory = ControlStep.__call__(self, readings, memory)
            return (*commands.values(), *(memory[key] for key in self._memory_order))

        # Trace it through autograd into one flat graph.
        examples = [
            value.clone() for value in inputs
        ]  # twice the same tensor would be taken for one
        decompositions = {
            torch.ops.aten.mm.default: _written_out,
            torch.ops.aten.bmm.default: _written_out,
        }
        graph = make_fx(flat_step, decompositions)(*examples)
        graph.graph.eliminate_dead_code()
        graph.recompile()

        # Calls from C++ are a third cheaper than from Python; torch 2.10 cannot make them.
        if inputs[0].device.type == "cpu":
            with suppress(Exception):
                return _compile_graph(graph, examples, cpp_wrapper=True)
        return _compile_graph(graph, examples, cpp_wrapper=False)


def _compile_graph(
    graph: GraphModule, examples: Sequence[Tensor], cpp_wrapper: bool
) -> CompiledFunction:
    """Compile a flat graph by TorchInductor."""
    from torch._inductor import config, standalone_compile  # takes a second to load

    with (
        torch.no_grad(),
        config.patch(cpp_wrapper=cpp_wrapper),
        _quiet("torch._inductor.ir"),
    ):
        compiled: CompiledFunction = standalone_compile(
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
