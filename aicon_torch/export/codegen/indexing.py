"""Operators that move the numbers of tensors around.

Where the places are known, numpy moves them here, and the program does nothing. Where an index is
a number of the program, such as the gradient that leads, it chooses among all candidates.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from aicon_torch.export.codegen.arrays import Array, Writer, as_array
from aicon_torch.export.codegen.operators import Translation
from aicon_torch.export.codegen.scalars import CONSTANT, Kind, Number

# --- shapes


def reshape(writer: Writer, kind: Kind, value: Array, shape: Sequence[int]) -> Array:
    """Another shape."""
    if not isinstance(shape, Sequence):
        raise NotImplementedError(f"as {shape}")
    return value.reshape(tuple(shape))


def expand(writer: Writer, kind: Kind, value: Array, shape: Sequence[int], **_: Any) -> Array:
    """Copies along dimensions of size one; −1 leaves a dimension as it is."""
    added = len(shape) - value.ndim
    sizes = [value.shape[i - added] if size == -1 else size for i, size in enumerate(shape)]
    expanded = np.broadcast_to(value, sizes)
    expanded.flags.writeable = value.flags.writeable  # if nothing is repeated, it may be written
    return expanded


def permute(writer: Writer, kind: Kind, value: Array, dims: Sequence[int]) -> Array:
    """Dimensions in another order."""
    return value.transpose(tuple(dims))


def unsqueeze(writer: Writer, kind: Kind, value: Array, dim: int) -> Array:
    """One more dimension, of size one."""
    return np.expand_dims(value, dim)


def squeeze(
    writer: Writer, kind: Kind, value: Array, dims: int | Sequence[int] | None = None
) -> Array:
    """Without these dimensions, where their size is one."""
    named = range(value.ndim) if dims is None else [dims] if isinstance(dims, int) else dims
    gone = tuple(dim % value.ndim for dim in named if value.ndim and value.shape[dim] == 1)
    return value.squeeze(gone)


def pass_on(writer: Writer, kind: Kind, value: Array, *_: Any, **__: Any) -> Array:
    """The same."""
    return value


# --- parts


def part(
    writer: Writer,
    kind: Kind,
    value: Array,
    dim: int = 0,
    start: int | None = None,
    end: int | None = None,
    step: int = 1,
) -> Array:
    """A slice."""
    taken: Array = value[_along(value, dim, slice(start, end, step))]
    return taken


def row(writer: Writer, kind: Kind, value: Array, dim: int, index: int) -> Array:
    """The part at one index, without its dimension."""
    # A slice of one, since an index into a vector would be a bare number; −1 + 1 would end it at 0.
    end = index + 1 if index != -1 else None
    taken: Array = value[_along(value, dim, slice(index, end))]
    return taken.squeeze(dim)


def split(
    writer: Writer, kind: Kind, value: Array, sizes: Sequence[int], dim: int = 0
) -> list[Array]:
    """Parts of these sizes."""
    return np.split(value, np.cumsum(sizes)[:-1], axis=dim)


def rows(writer: Writer, kind: Kind, value: Array, dim: int = 0) -> list[Array]:
    """Every part along a dimension, without it."""
    return [row(writer, kind, value, dim, index) for index in range(value.shape[dim])]


def diagonal(
    writer: Writer, kind: Kind, value: Array, offset: int = 0, dim1: int = 0, dim2: int = 1
) -> Array:
    """A diagonal, as the last dimension."""
    found = value.diagonal(offset, dim1, dim2)
    found.flags.writeable = value.flags.writeable
    return found


def flip(writer: Writer, kind: Kind, value: Array, dims: Sequence[int]) -> Array:
    """Backward along these dimensions."""
    return np.flip(value, tuple(dims))


def join(writer: Writer, kind: Kind, values: Sequence[Array], dim: int = 0) -> Array:
    """Parts one after the other."""
    # torch joins an empty vector to anything, numpy does not.
    parts = [value for value in values if value.shape != (0,)] or values[:1]
    return writer.cast(np.concatenate(parts, axis=dim), kind)


def pad(
    writer: Writer, kind: Kind, value: Array, widths: Sequence[int], filling: float = 0
) -> Array:
    """More elements on either side, from the last dimension to the first; fewer where negative."""
    # A pair for each dimension, the last one first; none for those in front.
    pairs = list(zip(widths[::2], widths[1::2], strict=True))
    pairs += [(0, 0)] * (value.ndim - len(pairs))

    # Negative widths take elements away, ...
    for dim, (before, after) in enumerate(pairs[::-1]):
        value = value.take(range(max(-before, 0), value.shape[dim] - max(-after, 0)), axis=dim)

    # ... and what is left goes into a larger array of the filling.
    pairs = [(max(before, 0), max(after, 0)) for before, after in pairs]
    inner = tuple(
        slice(before, before + size)
        for (before, _), size in zip(pairs[::-1], value.shape, strict=True)
    )

    shape = [sum(pair) + size for pair, size in zip(pairs[::-1], value.shape, strict=True)]
    return _replaced(writer.full(shape, filling, kind), inner, value)


# --- with a part replaced


def replace_part(
    writer: Writer,
    kind: Kind,
    value: Array,
    source: Array,
    dim: int = 0,
    start: int | None = None,
    end: int | None = None,
    step: int = 1,
) -> Array:
    """The value, with a slice replaced."""
    return _replaced(value, _along(value, dim, slice(start, end, step)), source)


def replace_row(
    writer: Writer, kind: Kind, value: Array, source: Array, dim: int, index: int
) -> Array:
    """The value, with the part at one index replaced."""
    return _replaced(value, _along(value, dim, index), source)


def replace_diagonal(
    writer: Writer,
    kind: Kind,
    value: Array,
    source: Array,
    offset: int = 0,
    dim1: int = 0,
    dim2: int = 1,
) -> Array:
    """The value, with a diagonal replaced."""
    # numpy's diagonal is read-only, so that of the places is taken, and these are overwritten.
    places = np.arange(value.size).reshape(value.shape).diagonal(offset, dim1, dim2)
    replaced = value.copy()
    replaced.reshape(-1)[places] = source
    return replaced


def copied(writer: Writer, kind: Kind, value: Array, source: Array, *_: Any) -> Array:
    """A source in the shape of another value."""
    return np.broadcast_to(writer.cast(source, kind), value.shape).copy()


# --- by index


def take(writer: Writer, kind: Kind, value: Array, dim: int, index: Array) -> Array:
    """The parts at some indices."""
    # Places that are known now cost nothing when the program runs.
    places = _known(index)
    if places is not None:
        found: Array = np.take(value, places, axis=dim)
        return found

    # Else every number of every part is picked there.
    along = np.moveaxis(value, dim, 0)
    taken = [_pick_parts(writer, along, number) for number in index.reshape(-1)]
    return np.moveaxis(np.stack(taken), 0, dim)


def gather(writer: Writer, kind: Kind, value: Array, dim: int, index: Array, **_: Any) -> Array:
    """For each element of the index the candidate there, along a dimension."""
    chosen = np.empty(index.shape, dtype=object)
    for place in np.ndindex(index.shape):
        candidates: Any = value[_across(place, dim)] if value.ndim else value.reshape(1)
        number: Any = index[place]
        chosen[place] = writer.pick(candidates, number)
    return chosen


def scatter(
    writer: Writer,
    kind: Kind,
    value: Array,
    dim: int,
    index: Array,
    source: Any,
    reduce: str | None = None,
) -> Array:
    """The value, with elements of a source where the index says."""
    if reduce is not None:
        raise NotImplementedError(f"with reduce={reduce!r}")
    return _scatter(writer, kind, value, dim, index, source, adds=False)


def scatter_add(
    writer: Writer, kind: Kind, value: Array, dim: int, index: Array, source: Any
) -> Array:
    """The value, with elements of a source added where the index says."""
    return _scatter(writer, kind, value, dim, index, source, adds=True)


def index_by(writer: Writer, kind: Kind, value: Array, indices: Sequence[Array | None]) -> Array:
    """Indexing by arrays of indices."""
    places = _all_known(indices)
    if places is not None:
        return np.asarray(value[places], dtype=object)

    # One index that is known when the program runs only.
    dim, index = _only(indices)
    count = value.shape[dim]

    # Negative indices count from the end.
    is_from_end = writer.map("lt", "bool", index, 0)
    wrapped = writer.map("where", "int", is_from_end, writer.map("add", "int", index, count), index)
    along = np.moveaxis(value, dim, 0)
    taken = [_pick_parts(writer, along, number) for number in wrapped.reshape(-1)]

    # The dimensions of the index take the place of the one that it chooses from.
    stacked = np.stack(taken).reshape(*index.shape, *along.shape[1:])
    here = range(dim, dim + index.ndim)
    return np.moveaxis(stacked, range(index.ndim), here)


def index_put(
    writer: Writer,
    kind: Kind,
    value: Array,
    indices: Sequence[Array | None],
    source: Array,
    accumulate: bool = False,
) -> Array:
    """The value, with elements of a source at arrays of indices, or added there."""
    places = _all_known(indices)
    if places is None:
        raise NotImplementedError("at places that are known when the program runs only")

    result = value.copy()

    # Flat places, one by one: of a place that is named twice, both elements shall be added.
    targets = np.arange(value.size).reshape(value.shape)[places]
    flat, sources = result.reshape(-1), np.broadcast_to(source, targets.shape)
    for place in np.ndindex(targets.shape):
        added = writer.cast(np.asarray(sources[place], dtype=object), kind).item()
        if accumulate:
            added = writer.program.apply("add", (flat[targets[place]], added), kind)
        flat[targets[place]] = added
    return flat.reshape(value.shape)


def _scatter(
    writer: Writer, kind: Kind, value: Array, dim: int, index: Array, source: Any, adds: bool
) -> Array:
    result = np.atleast_1d(writer.cast(value, kind))
    index = np.atleast_1d(index)

    # A source may be larger than the index, which then meets its first elements.
    sources = writer.array(source, kind)
    sources = sources[tuple(slice(size) for size in index.shape[: sources.ndim])]
    sources = np.broadcast_to(sources, index.shape)
    for place in np.ndindex(index.shape):
        line: Any = result[_across(place, dim)]
        number: Any = index[place]

        # Which place is meant is known when the program runs only, so each one asks.
        for target in range(len(line)):
            new: Any = sources[place]
            if adds:
                new = writer.program.apply("add", (line[target], new), kind)
            is_here = writer.is_at(number, target)
            line[target] = writer.program.apply("where", (is_here, new, line[target]), kind)
    return result.reshape(value.shape)


def _pick_parts(writer: Writer, along: Array, index: Number) -> Array:
    """The part of an array, along its first dimension, at an index."""
    columns: Any = along.reshape(len(along), -1).T
    picked = [writer.pick(column, index) for column in columns]
    return as_array(picked, along.shape[1:])


def _along(value: Array, dim: int, index: slice | int) -> tuple[Any, ...]:
    """An index along one dimension, and everything along the others."""
    full: list[slice | int] = [slice(None)] * value.ndim
    full[dim] = index
    return tuple(full)


def _across(place: tuple[int, ...], dim: int) -> tuple[Any, ...]:
    """A place, and everything along one dimension."""
    full: list[slice | int] = list(place)
    full[dim] = slice(None)
    return tuple(full)


def _replaced(value: Array, where: tuple[Any, ...], source: Array) -> Array:
    replaced = value.copy()
    replaced[where] = source
    return replaced


def _known(index: Array) -> Any:
    """The indices as integers, or as truth values; None where the program computes them."""
    numbers: list[Number] = list(index.reshape(-1))
    if any(number.operation != CONSTANT for number in numbers):
        return None
    values = [number.value for number in numbers]
    return np.array(values, dtype=None if values else np.int64).reshape(index.shape)


def _all_known(indices: Sequence[Array | None]) -> tuple[Any, ...] | None:
    places = [slice(None) if index is None else _known(index) for index in indices]
    return None if any(place is None for place in places) else tuple(places)


def _only(indices: Sequence[Array | None]) -> tuple[int, Array]:
    """The one index among these, and its dimension."""
    given = [(dim, index) for dim, index in enumerate(indices) if index is not None]
    if len(given) != 1 or given[0][1].flat[0].kind == "bool":
        raise NotImplementedError("by several indices that are known when the program runs only")
    return given[0]


INDEXING: dict[str, Translation] = {
    "view": reshape,
    "_unsafe_view": reshape,
    "reshape": reshape,
    "expand": expand,
    "permute": permute,
    "unsqueeze": unsqueeze,
    "squeeze": squeeze,
    "alias": pass_on,
    "detach": pass_on,
    "slice": part,
    "select": row,
    "split_with_sizes": split,
    "unbind": rows,
    "diagonal": diagonal,
    "flip": flip,
    "cat": join,
    "constant_pad_nd": pad,
    "slice_scatter": replace_part,
    "select_scatter": replace_row,
    "diagonal_scatter": replace_diagonal,
    "copy": copied,
    "index_select": take,
    "gather": gather,
    "scatter": scatter,
    "scatter_add": scatter_add,
    "index": index_by,
    "index_put": index_put,
}
"""The translation of each operator that moves numbers, by its name in aten without the overload."""
