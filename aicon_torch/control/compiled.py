"""The compiled policy: one control step as machine code, traced once for each size of batch."""

import logging
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from typing import Any

import torch
from numpy.typing import ArrayLike
from torch import Tensor
from torch.fx.experimental.proxy_tensor import make_fx

from aicon_torch.control.policy import Policy
from aicon_torch.resolution import Memory

_SMALL = 16
"""Products of matrices up to this size are written out, since to call a library costs more than they do."""

Run = Callable[..., Sequence[Tensor]]
"""A compiled step: from the values of readings and memory to those of commands and memory, each in a fixed order."""


class CompiledPolicy(Policy):
    """A policy that acts like the one it is made of, many times faster.

    The first step with a new size of batch is traced through autograd into one flat graph of tensor operations, in
    which every gradient is written out, and TorchInductor compiles it. That takes from seconds to a minute; later runs
    find most of it in Inductor's cache on disk. Observations are checked, and episodes begin, as before.

    A new precision or device is compiled by itself; where a parameter has changed, call ``compile`` again. The step
    must not branch on values of tensors. Where it does, or where there is no compiler, the policy warns once and goes
    on uncompiled.

    Args:
        policy: The policy, with which it shares its parts.
    """

    def __init__(self, policy: Policy) -> None:
        super().__init__(policy.model, policy.resolution, policy.law)
        self._before_step = policy._begin  # what the policy makes of an observation stays as it is, images included
        self._order = tuple(sorted(self._keys))
        self._runs: dict[tuple[torch.Size, torch.dtype, torch.device], Run] = {}
        self._compiles = True

    def _begin(
        self, observation: Mapping[str, Any], state: Memory | None, episode_start: ArrayLike | Tensor | None
    ) -> tuple[Memory, dict[str, Tensor]]:
        return self._before_step(observation, state, episode_start)

    def _step(self, readings: Mapping[str, Tensor], before: Memory) -> tuple[dict[str, Tensor], Memory]:
        if not self._compiles:
            return super()._step(readings, before)
        names = sorted(readings)
        inputs = [*(readings[name].contiguous() for name in names), *(before[n].contiguous() for n in self._order)]
        kind = (inputs[0].shape, inputs[0].dtype, inputs[0].device)
        if kind not in self._runs:
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")  # torch on its own future
                    self._runs[kind] = self._compiled(names, inputs)
            except Exception as error:  # noqa: BLE001  # whatever the compiler says, the robot goes on
                warnings.warn(
                    f"The policy runs uncompiled, more slowly: {_summary(error)}. Compiling needs a C++ compiler "
                    "(Debian: apt install g++) and a step that does not branch on values of tensors.",
                    RuntimeWarning,
                    stacklevel=3,
                )
                self._compiles = False
                return super()._step(readings, before)
        with torch.no_grad():
            outputs = self._runs[kind](*inputs)
        split = len(self.model.actuators)
        return (
            dict(zip(self.model.actuators, outputs[:split], strict=True)),
            dict(zip(self._order, outputs[split:], strict=True)),
        )

    def _compiled(self, names: Sequence[str], inputs: Sequence[Tensor]) -> Run:
        """The step for inputs of these shapes."""
        from torch._inductor import config, standalone_compile  # takes a second to load

        def step(*values: Tensor) -> tuple[Tensor, ...]:
            readings = dict(zip(names, values, strict=False))
            before = dict(zip(self._order, values[len(names) :], strict=True))
            commands, memory = Policy._step(self, readings, before)
            return (*commands.values(), *(memory[name] for name in self._order))

        examples = [value.clone() for value in inputs]  # a tensor that comes in twice would be taken for one
        graph = make_fx(step, {torch.ops.aten.mm.default: _product, torch.ops.aten.bmm.default: _product})(*examples)
        graph.graph.eliminate_dead_code()
        graph.recompile()

        def compiled(cpp_wrapper: bool) -> Run:
            with torch.no_grad(), config.patch(cpp_wrapper=cpp_wrapper), _quiet("torch._inductor.ir"):
                run: Run = standalone_compile(graph, [*examples], dynamic_shapes="from_example_inputs")
            return run

        if inputs[0].device.type == "cpu":
            with suppress(Exception):  # torch 2.10 cannot; there, calls from Python cost another third of a step
                return compiled(cpp_wrapper=True)
        return compiled(cpp_wrapper=False)


@contextmanager
def _quiet(name: str) -> Iterator[None]:
    """Leave out the warnings of a logger: which operations it knows no shortcut for is not the user's business."""
    logger = logging.getLogger(name)
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        yield
    finally:
        logger.setLevel(level)


def _product(first: Tensor, second: Tensor) -> Tensor:
    """``(..., n, k)`` times ``(..., k, m)``, as a sum that is compiled together with what is around it."""
    if max(*first.shape[-2:], *second.shape[-2:]) > _SMALL:
        return NotImplemented  # type: ignore[no-any-return]  # it stays a call
    product: Tensor = (first.unsqueeze(-1) * second.unsqueeze(-3)).sum(-2)
    return product


def _summary(error: Exception) -> str:
    lines = str(error).strip().splitlines()
    return f"{type(error).__name__}: {lines[0] if lines else 'no message'}"
