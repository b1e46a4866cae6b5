"""Operators that compare the numbers of a tensor: the largest, the order, running sums."""

from typing import Any

import numpy as np

from aicon_torch.export.codegen.arrays import Array, Writer
from aicon_torch.export.codegen.operators import Translation
from aicon_torch.export.codegen.scalars import Kind, Number

Best = tuple[Number, Number]
"""A value, and its index."""

COMPARED = 64
"""Times that a number is looked at, in picking the best of many, from which on a loop does it."""

SELECTION_ROUTINES = {
    "in_order": """\
/* Whether a stands before b, with the largest first or the smallest; NaN is larger than all. */
static inline int is_before(int largest, real a, real b) {
  return largest ? is_above(a, b) : is_above(b, a);
}
/* Each of n numbers that stands no later than a bound, sorted in among those before it, of which so
   many are kept; then their places. */
static void sort_in(int n, int count, int largest, real bound, const real *x, real *y) {
  real *places = y + count;
  for (int i = 0, found = 0; i < n; ++i) {
    if (largest ? x[i] < bound : x[i] > bound) continue;
    int k = found;
    for (; k > 0 && is_before(largest, x[i], y[k - 1]); --k)
      if (k < count) y[k] = y[k - 1], places[k] = places[k - 1];
    if (k < count) y[k] = x[i], places[k] = (real)i;
    if (found < count) ++found;
  }
}
/* The largest of n numbers in order, or the smallest, and their places. Of equal ones the first
   comes first. */
static void in_order(int n, int count, int largest, const real *x, real *y) {
  real bound = NAN; /* nothing stands after it */

  /* Many are dealt into as many heaps as are asked for. So many of them, the firsts of the heaps,
     stand no later than the last of these firsts: what stands after it is not meant. A NaN may be
     first of a heap by mistake, and only lets more of them pass. */
  if (n > 4 * count) {
    real firsts[count];
    for (int k = 0; k < count; ++k) firsts[k] = x[k];
    for (int i = count; i < n; i += count) {
      int left = n - i < count ? n - i : count;
      for (int k = 0; k < left; ++k)
        firsts[k] = largest ? larger(x[i + k], firsts[k]) : smaller(x[i + k], firsts[k]);
    }
    bound = firsts[0];
    for (int k = 1; k < count; ++k)
      bound = largest ? smaller(firsts[k], bound) : larger(firsts[k], bound);
  }
  sort_in(n, count, largest, bound, x, y);
}
""",
}
"""The routines in C."""


def extreme_index(is_better: str) -> Translation:
    """The translation of argmax (``"gt"``) and argmin (``"lt"``)."""

    def translation(
        writer: Writer, kind: Kind, value: Array, dim: int | None = None, keepdim: bool = False
    ) -> Array:
        if dim is None:
            return _extreme(writer, value.reshape(-1), 0, is_better, False)[1]
        return _extreme(writer, value, dim, is_better, keepdim)[1]

    return translation


def extreme(is_better: str) -> Translation:
    """The translation of max and min along a dimension: values and indices."""

    def translation(
        writer: Writer, kind: Kind, value: Array, dim: int, keepdim: bool = False
    ) -> tuple[Array, Array]:
        return _extreme(writer, value, dim, is_better, keepdim)

    return translation


def topk(
    writer: Writer,
    kind: Kind,
    value: Array,
    count: int,
    dim: int = -1,
    largest: bool = True,
    sorted: bool = True,
) -> tuple[Array, Array]:
    """The largest or smallest values in order, and their indices; NaN is larger than all."""
    # Among the smallest NaN comes last, where a minimum (`lt`) would take it first.
    is_better = "gt" if largest else "below"
    return _along(writer, value, dim, count, is_better)


def sort(
    writer: Writer,
    kind: Kind,
    value: Array,
    dim: int = -1,
    descending: bool = False,
    stable: bool = True,
) -> tuple[Array, Array]:
    """All values in order, and their indices; equal ones stay in theirs."""
    count = value.shape[dim] if value.ndim else 1
    return topk(writer, kind, value, count, dim, largest=descending)


def running_sum(writer: Writer, kind: Kind, value: Array, dim: int, **_: Any) -> Array:
    """The sum of each element and those before it."""
    along = np.moveaxis(np.atleast_1d(writer.cast(value, kind)), dim, 0)
    sums = [along[:1]]
    for place in range(1, len(along)):
        sums.append(writer.map("add", kind, sums[-1], along[place : place + 1]))
    return np.moveaxis(np.concatenate(sums), 0, dim).reshape(value.shape)


def _extreme(
    writer: Writer, value: Array, dim: int, is_better: str, keepdim: bool
) -> tuple[Array, Array]:
    values, indices = _along(writer, value, dim, 1, is_better)
    if keepdim:
        return values, indices
    return values.squeeze(dim), indices.squeeze(dim)


def _along(
    writer: Writer, value: Array, dim: int, count: int, is_better: str
) -> tuple[Array, Array]:
    """The first values of each line along a dimension in order, and their indices."""
    # The dimension goes last, and each line along it is searched by itself.
    moved = np.moveaxis(np.atleast_1d(value), dim, -1)
    values, indices = (np.empty((*moved.shape[:-1], count), dtype=object) for _ in range(2))
    for place in np.ndindex(moved.shape[:-1]):
        for rank, best in enumerate(_in_order(writer, moved[place], count, is_better)):
            values[(*place, rank)], indices[(*place, rank)] = best

    # As many of each line as were found, in the place of the dimension.
    if not value.ndim:
        return values.reshape(()), indices.reshape(())
    return np.moveaxis(values, -1, dim), np.moveaxis(indices, -1, dim)


def _in_order(writer: Writer, line: Array, count: int, is_better: str) -> list[Best]:
    """The first of a line in order: the best of all, the best of the others, and so on."""
    program = writer.program

    # Many numbers: a routine of C sorts them in, and returns the values, then their places.
    if count > 1 and len(line) * count >= COMPARED and line[0].kind == "real":
        sizes = (len(line), count, int(is_better == "gt"), 2 * count)
        array = writer.whole(list(line))
        call = program.call("in_order", line if array is None else [array], sizes)
        values = [program.item(call, k) for k in range(count)]
        places = [program.cast(program.item(call, count + k), "int") for k in range(count)]
        return list(zip(values, places, strict=True))

    # Few: for each rank a contest among those that no rank before has taken. At the first rank
    # nothing is taken, which is known now, so that the conditions on it fold away.
    taken = [program.constant(False, "bool")] * len(line)

    order: list[Best] = []
    for _ in range(count):
        best, index = line[0], program.constant(0, "int")
        is_free = program.apply("not", (taken[0],), "bool")
        for place in range(1, len(line)):
            # A candidate that is free takes over from one that is worse, or that is taken.
            better = _is_better(writer, line[place], best, is_better)
            takes = program.apply("or", (better, program.apply("not", (is_free,), "bool")), "bool")
            free_here = program.apply("not", (taken[place],), "bool")
            takes = program.apply("and", (takes, free_here), "bool")

            best = program.apply("where", (takes, line[place], best), best.kind)
            here = program.constant(place, "int")
            index = program.apply("where", (takes, here, index), "int")
            is_free = program.apply("or", (is_free, takes), "bool")

        order.append((best, index))

        # Who holds this rank takes no part in the next contest.
        for place in range(len(line)):
            is_here = writer.is_at(index, place)
            taken[place] = program.apply("or", (taken[place], is_here), "bool")
    return order


def _is_better(writer: Writer, candidate: Number, best: Number, is_better: str) -> Number:
    """Whether a candidate is larger (``"gt"``) or smaller (``"lt"``), or NaN, which is both.

    A candidate is *below* (``"below"``) where the best one is larger, or NaN.
    """
    if is_better == "below":
        candidate, best, is_better = best, candidate, "gt"
    operation = f"{is_better}_or_nan" if candidate.kind == "real" else is_better
    return writer.program.apply(operation, (candidate, best), "bool")


SELECTION: dict[str, Translation] = {
    "argmax": extreme_index("gt"),
    "argmin": extreme_index("lt"),
    "max": extreme("gt"),
    "min": extreme("lt"),
    "topk": topk,
    "sort": sort,
    "cumsum": running_sum,
}
"""The translation of each operator that compares, by its name in aten without the overload."""
