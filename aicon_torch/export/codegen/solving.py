"""Operators that solve linear systems, as calls of routines that pivot as LAPACK does."""

from typing import Any

import numpy as np

from aicon_torch.export.codegen.arrays import Array, Writer, as_array
from aicon_torch.export.codegen.operators import Translation
from aicon_torch.export.codegen.scalars import Kind

ROUTINES = {
    "factorize": """\
/* A = P L U by rows with partial pivoting; result: L and U in one, then the rows exchanged. */
static void factorize(int n, const real *a, real *result) {
  real *lu = result, *rows = result + n * n;
  for (int i = 0; i < n * n; ++i) lu[i] = a[i];
  for (int k = 0; k < n; ++k) {
    int best = k;
    for (int i = k + 1; i < n; ++i)
      if (magnitude(lu[i * n + k]) > magnitude(lu[best * n + k])) best = i;
    rows[k] = (real)(best + 1);
    if (best != k)
      for (int j = 0; j < n; ++j) {
        real held = lu[k * n + j];
        lu[k * n + j] = lu[best * n + j];
        lu[best * n + j] = held;
      }
    if (lu[k * n + k] == 0) continue; /* the column is zero from here on, and stays so */
    for (int i = k + 1; i < n; ++i) {
      real factor = lu[i * n + k] /= lu[k * n + k];
      for (int j = k + 1; j < n; ++j) lu[i * n + j] -= factor * lu[k * n + j];
    }
  }
}
""",
    "substitute": """\
/* X of A X = B, for m columns, from what factorize found of A. */
static void substitute(int n, int m, const real *lu, const real *rows, const real *b, real *x) {
  for (int i = 0; i < n * m; ++i) x[i] = b[i];
  for (int k = 0; k < n; ++k) {
    int other = (int)rows[k] - 1;
    if (other != k)
      for (int j = 0; j < m; ++j) {
        real held = x[k * m + j];
        x[k * m + j] = x[other * m + j];
        x[other * m + j] = held;
      }
  }
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < i; ++k)
      for (int j = 0; j < m; ++j) x[i * m + j] -= lu[i * n + k] * x[k * m + j];
  for (int i = n - 1; i >= 0; --i)
    for (int j = 0; j < m; ++j) {
      for (int k = i + 1; k < n; ++k) x[i * m + j] -= lu[i * n + k] * x[k * m + j];
      x[i * m + j] /= lu[i * n + i];
    }
}
""",
    "substitute_adjoint": """\
/* X of A' X = B, for m columns, from what factorize found of A. */
static void substitute_adjoint(int n, int m, const real *lu, const real *rows, const real *b,
                               real *x) {
  for (int i = 0; i < n * m; ++i) x[i] = b[i];
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < m; ++j) {
      for (int k = 0; k < i; ++k) x[i * m + j] -= lu[k * n + i] * x[k * m + j];
      x[i * m + j] /= lu[i * n + i];
    }
  for (int i = n - 1; i >= 0; --i)
    for (int k = i + 1; k < n; ++k)
      for (int j = 0; j < m; ++j) x[i * m + j] -= lu[k * n + i] * x[k * m + j];
  for (int k = n - 1; k >= 0; --k) {
    int other = (int)rows[k] - 1;
    if (other != k)
      for (int j = 0; j < m; ++j) {
        real held = x[k * m + j];
        x[k * m + j] = x[other * m + j];
        x[other * m + j] = held;
      }
  }
}
""",
}
"""The routines in C."""


def solve_ex(
    writer: Writer, kind: Kind, matrix: Array, right: Array, left: bool = True, **_: Any
) -> tuple[Array, ...]:
    """X of A X = B, the factors of A, the rows exchanged, and the first pivot that is zero."""
    # One right-hand side for each A is a matrix of one column.
    is_vector = right.ndim == 1 or right.shape == matrix.shape[:-1]
    if is_vector:
        right = right[..., None]
    factors, rows, zero = factorize(writer, kind, matrix)
    solution = substitute(writer, kind, factors, rows, right, left)
    return solution.squeeze(-1) if is_vector else solution, factors, rows, zero


def factorize(writer: Writer, kind: Kind, matrix: Array, **_: Any) -> tuple[Array, ...]:
    """L and U in one ``(..., n, n)``, the rows exchanged ``(..., n)``, and the first zero pivot."""
    size = matrix.shape[-1]
    factors = np.empty(matrix.shape, dtype=object)
    rows = np.empty(matrix.shape[:-1], dtype=object)

    for place in np.ndindex(matrix.shape[:-2]):
        numbers = writer.cast(matrix[place], "real").reshape(-1)

        # L and U fill the first n² results, the rows exchanged the last n.
        call = writer.program.call("factorize", numbers, (size, size * size + size))
        items = [writer.program.item(call, index) for index in range(size * size + size)]
        factors[place] = as_array(items[: size * size], (size, size))
        rows[place] = as_array(items[size * size :], (size,))
    return factors, rows, _first_zero_pivot(writer, factors)


def _first_zero_pivot(writer: Writer, factors: Array) -> Array:
    """Which pivot is the first that is zero, counted from 1; 0 where A is not singular."""
    first = writer.full(factors.shape[:-2], 0, "int")
    for row in reversed(range(factors.shape[-1])):
        is_zero = writer.map("eq", "bool", factors[..., row, row], 0.0)
        first = writer.map("where", "int", is_zero, row + 1, first)
    return first


def substitute(
    writer: Writer,
    kind: Kind,
    factors: Array,
    rows: Array,
    right: Array,
    left: bool = True,
    adjoint: bool = False,
) -> Array:
    """X of A X = B ``(..., n, m)`` from the factors of A; of A transposed, or of X A = B."""
    if not left:  # Aᵀ Xᵀ = Bᵀ
        turned = right.swapaxes(-1, -2)
        return substitute(writer, kind, factors, rows, turned, True, not adjoint).swapaxes(-1, -2)

    # Factors, rows exchanged and B are one flat argument of the routine.
    routine = "substitute_adjoint" if adjoint else "substitute"
    size, columns = right.shape[-2:]
    leading = np.broadcast_shapes(factors.shape[:-2], right.shape[:-2])
    solution = np.empty((*leading, size, columns), dtype=object)
    right = np.broadcast_to(right, solution.shape)
    factors = np.broadcast_to(factors, (*leading, size, size))
    rows = np.broadcast_to(rows, (*leading, size))
    for place in np.ndindex(leading):
        parts = (factors[place], rows[place], right[place])
        numbers = np.concatenate([writer.cast(part, "real").reshape(-1) for part in parts])
        call = writer.program.call(routine, numbers, (size, columns, size * columns))
        items = [writer.program.item(call, index) for index in range(size * columns)]
        solution[place] = as_array(items, (size, columns))
    return solution


SOLVING: dict[str, Translation] = {
    "_linalg_solve_ex": solve_ex,
    "linalg_lu_factor_ex": factorize,
    "linalg_lu_solve": substitute,
}
"""The translation of each operator that solves, by its name in aten without the overload."""
