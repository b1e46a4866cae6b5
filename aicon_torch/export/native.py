"""The step of a compiled policy on the CPU: translated to C when it is first needed."""

import logging
from collections.abc import Iterable
from typing import Any, TypeAlias

import torch
from torch import Tensor, nn

from aicon_torch.control.step import ControlStep
from aicon_torch.differentiation import undisturbed
from aicon_torch.errors import OptionError
from aicon_torch.export.exported_policy import ExportedPolicy
from aicon_torch.readings.perception import Perception

_LOGGER = logging.getLogger(__name__)

Version: TypeAlias = tuple[Tensor, int, int | None]
"""A tensor, how often it was changed in place, and where its numbers are, if that is asked."""


class NativeSteps:
    """The libraries of a policy, one for each precision that it is used in."""

    def __init__(self) -> None:
        self._steps: dict[torch.dtype, ExportedPolicy | None] = {}
        self._versions: dict[torch.dtype, list[Version]] = {}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """A copy has the same libraries, and tensors of its own that are as they were."""
        self.__dict__.update(state)
        for dtype, known in self._versions.items():
            self._versions[dtype] = _versions_of(tensor for tensor, *_ in known)

    def of(self, step: ControlStep, perception: Perception | None) -> ExportedPolicy | None:
        """The library of a step, as a policy; None where it must run otherwise.

        Args:
            step: The step.
            perception: What stands before it.

        Raises:
            OptionError: If a parameter or a buffer has changed since it was translated.
        """
        like = step.model.like
        if like.device.type != "cpu":
            return None

        if like.dtype not in self._steps:
            # Noted before, and there before the step is: other threads may change one or run the
            # other meanwhile.
            versions = _versions_of((*step.model.parameters(), *step.model.buffers()))
            translated = self._translated(step, perception)
            self._versions[like.dtype] = versions
            self._steps[like.dtype] = translated

        # torch counts changes in place, and the C code holds parameters and buffers as they were.
        for tensor, version, place in self._versions[like.dtype]:
            if tensor._version != version or (place is not None and tensor.data_ptr() != place):
                raise OptionError(
                    "The policy was compiled before its parameters or buffers changed: call "
                    "compile() again."
                )
        return self._steps[like.dtype]

    @staticmethod
    def _translated(step: ControlStep, perception: Perception | None) -> ExportedPolicy | None:
        from aicon_torch.export.exporting import compiled_library  # loads the translation to C

        # The step as it is written; the one that is given may be compiled by TorchInductor.
        plain = ControlStep(step.model, step.backward, step.law)
        try:
            with undisturbed(step.model.like), torch.enable_grad():  # gradients are traced
                library = compiled_library(plain, perceives=perception is not None)
        except Exception as error:  # noqa: BLE001  # it runs otherwise, or says there why it cannot
            _LOGGER.warning(
                "The step does not run as C, and TorchInductor is tried instead: its first step "
                "takes minutes, every other one up to fifty times as long. %s",
                error,
            )
            return None
        return ExportedPolicy(library, perception)


def _versions_of(tensors: Iterable[Tensor]) -> list[Version]:
    """Tensors, each with how often it was changed in place and, of a parameter, where it is.

    An optimizer may give a parameter other numbers as its ``data``; a buffer is loaded in place.
    """
    return [
        (tensor, tensor._version, tensor.data_ptr() if isinstance(tensor, nn.Parameter) else None)
        for tensor in tensors
    ]
