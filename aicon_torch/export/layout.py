"""Named tensors in one flat one, and back."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor

INTEGERS = {"int": torch.int64, "bool": torch.bool}
"""The type of entries that are not real numbers, by their kind."""


@dataclass(frozen=True)
class Entry:
    """A named tensor within a flat one.

    Attributes:
        name: Its name.
        shape: Its shape, without leading batch dimensions.
        kind: What its elements are, ``"real"``, ``"int"`` or ``"bool"``; in the flat tensor all are
            real numbers.
        start: Where it begins.
        stop: Where it ends.
    """

    name: str
    shape: tuple[int, ...]
    kind: str
    start: int
    stop: int

    def of(self, flat: Tensor) -> Tensor:
        """The named tensor ``(*B, *shape)`` out of the flat one ``(*B, n)``."""
        part = flat[..., self.start : self.stop].reshape((*flat.shape[:-1], *self.shape))
        return part.to(INTEGERS[self.kind]) if self.kind in INTEGERS else part


class Layout:
    """Where named tensors stand in a flat one.

    Args:
        entries: One after the other.
    """

    def __init__(self, entries: tuple[Entry, ...]) -> None:
        self.entries = {entry.name: entry for entry in entries}
        self.size = entries[-1].stop if entries else 0

    @classmethod
    def of(cls, values: Mapping[str, Tensor]) -> "Layout":
        """That of some tensors, without batch dimensions."""
        return cls._in_a_row(
            (name, tuple(value.shape), _kind_of(value)) for name, value in values.items()
        )

    @classmethod
    def _in_a_row(cls, described: Iterable[tuple[str, tuple[int, ...], str]]) -> "Layout":
        """Entries by name, shape and kind, each where the one before it ends."""
        entries: list[Entry] = []
        start = 0
        for name, shape, kind in described:
            stop = start + torch.Size(shape).numel()
            entries.append(Entry(name, shape, kind, start, stop))
            start = stop
        return cls(tuple(entries))

    @property
    def integers(self) -> dict[str, torch.dtype]:
        """The types of what is no real number, by name."""
        kinds = {name: entry.kind for name, entry in self.entries.items()}
        return {name: INTEGERS[kind] for name, kind in kinds.items() if kind in INTEGERS}

    def pack(self, values: Mapping[str, Tensor], like: Tensor) -> Tensor:
        """One flat tensor ``(*B, n)`` of the type of another."""
        parts: list[Tensor] = []
        for name, entry in self.entries.items():
            value = values[name]

            # What stands before the entry's own shape is the batch.
            batch = value.shape[: value.dim() - len(entry.shape)]
            parts.append(value.reshape((*batch, entry.stop - entry.start)).to(like))
        return torch.cat(parts, dim=-1) if parts else like.new_empty(0)

    def unpack(self, flat: Tensor) -> dict[str, Tensor]:
        """The named tensors ``(*B, *shape)`` out of a flat one ``(*B, n)``."""
        return {name: entry.of(flat) for name, entry in self.entries.items()}

    def to_json(self) -> list[dict[str, Any]]:
        """As lists and dictionaries."""
        return [
            {"name": entry.name, "shape": list(entry.shape), "kind": entry.kind}
            for entry in self.entries.values()
        ]

    @classmethod
    def from_json(cls, listed: list[dict[str, Any]]) -> "Layout":
        """From what :meth:`to_json` gave."""
        # Where entries stand is not in the file: it follows from their order.
        return cls._in_a_row((item["name"], tuple(item["shape"]), item["kind"]) for item in listed)


def _kind_of(value: Tensor) -> str:
    if value.is_floating_point():
        return "real"
    return "bool" if value.dtype == torch.bool else "int"
