"""The memory of an exported policy: one flat array that is read by name."""

from collections import OrderedDict
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from aicon_torch.export.layout import Layout


class ExportedMemory(Mapping[str, Tensor]):
    """What :meth:`aicon_torch.policy.Policy.predict` returns as a dictionary, as one array.

    It is read like that dictionary, ``memory["x"]`` being ``(*B, *shape)``, and no step changes it.
    Saved or pickled it is a dictionary of tensors, which ``torch.load`` reads as it is by default.

    Args:
        flat: The numbers ``(*B, n)``.
        layout: Which of them are what.
    """

    __slots__ = ("flat", "layout")

    def __init__(self, flat: NDArray[Any], layout: Layout) -> None:
        self.flat, self.layout = flat, layout

    def __getitem__(self, name: str) -> Tensor:
        return self.layout.entries[name].of(torch.from_numpy(self.flat))

    def __iter__(self) -> Iterator[str]:
        return iter(self.layout.entries)

    def __len__(self) -> int:
        return len(self.layout.entries)

    def __or__(self, changes: Mapping[str, Tensor]) -> dict[str, Tensor]:
        """A dictionary of it, with some entries changed."""
        return {**self, **changes}

    def __copy__(self) -> "ExportedMemory":
        return ExportedMemory(self.flat, self.layout)

    def __deepcopy__(self, memo: dict[int, Any]) -> "ExportedMemory":
        return ExportedMemory(self.flat.copy(), self.layout)

    def __reduce__(self) -> tuple[Any, ...]:
        # Of dictionaries, torch.load takes this one as an object's description.
        return OrderedDict, ([(name, value.clone()) for name, value in self.items()],)

    @classmethod
    def of(cls, memory: Mapping[str, Tensor], layout: Layout, dtype: Any) -> "ExportedMemory":
        """A memory of the policy that was exported."""
        like = torch.from_numpy(np.empty(0, dtype=dtype))
        return cls(np.ascontiguousarray(layout.pack(memory, like).detach().numpy()), layout)
