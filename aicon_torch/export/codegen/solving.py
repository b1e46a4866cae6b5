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
    "sweep": """\
/* How long a vector of n components is. */
static real length(int n, const real *x) {
  real sum = 0;
  for (int k = 0; k < n; ++k) sum += x[k] * x[k];
  return root(sum);
}
/* Hildreth's sweeps for m rows and a box of n components in a metric, until they change nothing:
   x has w, the rows' normals, of length one or zero, bounds and effects, the box, and the inverse
   of the metric; y gets the action and the force of the bounds.

   A row that is kept with room to spare is looked at again when the action has travelled as far:
   before that it changes nothing. */
static void sweep(int m, int n, int sweeps, const real *x, real *y) {
  const real *normals = x + n, *bounds = normals + m * n, *effects = bounds + m;
  const real *low = effects + m, *high = low + n, *inverse = high + n;
  real changes[m * n], lengths[m], multipliers[m], due[m], widths[n], travelled = 0;
  real *action = y, *push = y + n;
  for (int i = 0; i < m; ++i) multipliers[i] = 0, due[i] = 0, lengths[i] = -1;
  for (int k = 0; k < n; ++k) {
    action[k] = x[k], push[k] = 0;
    widths[k] = length(n, inverse + k * n);
  }

  for (int changed = 1; sweeps > 0 && changed; --sweeps) {
    changed = 0;
    for (int i = 0; i < m; ++i) {
      if (travelled < due[i]) continue;
      real along = 0;
      for (int k = 0; k < n; ++k) along += normals[i * n + k] * action[k];
      real multiplier = larger(multipliers[i] + (bounds[i] - along) / effects[i], 0);
      real more = multiplier - multipliers[i];
      if (more == 0) {
        real room = along - bounds[i];
        if (multiplier == 0) due[i] = travelled + room - ROUNDING * (1 + travelled + room);
        continue;
      }

      /* The least change is along the row turned by the inverse of the metric. */
      real *change = changes + i * n;
      if (lengths[i] < 0) {
        for (int k = 0; k < n; ++k) {
          change[k] = 0;
          for (int j = 0; j < n; ++j) change[k] += normals[i * n + j] * inverse[j * n + k];
        }
        lengths[i] = length(n, change);
      }
      for (int k = 0; k < n; ++k) action[k] += more * change[k];
      travelled += magnitude(more) * lengths[i];
      multipliers[i] = multiplier;
      due[i] = 0;
      changed = 1;
    }
    for (int k = 0; k < n; ++k) {
      real effect = inverse[k * n + k], free = action[k] - push[k] * effect;
      real needed = (smaller(larger(free, low[k]), high[k]) - free) / effect;
      real more = needed - push[k];
      if (more == 0) continue;
      for (int j = 0; j < n; ++j) action[j] += more * inverse[k * n + j];
      travelled += magnitude(more) * widths[k];
      push[k] = needed;
      changed = 1;
    }
  }
  for (int i = 0; i < m; ++i)
    if (multipliers[i] > 0)
      for (int k = 0; k < n; ++k) push[k] += multipliers[i] * normals[i * n + k];
}
""",
}
"""The routines in C."""


def solve_ex(
    writer: Writer, kind: Kind, matrix: Array, right: Array, left: bool = True, **_: Any
) -> tuple[Array, ...]:
    """X of A X = B, the factors of A, the rows exchanged, and 0 for success."""
    # One right-hand side for each A is a matrix of one column.
    is_vector = right.ndim == 1 or right.shape == matrix.shape[:-1]
    if is_vector:
        right = right[..., None]
    factors, rows = factorize(writer, kind, matrix)[:2]
    solution = substitute(writer, kind, factors, rows, right, left)

    success = writer.full(matrix.shape[:-2], 0, "int")
    return solution.squeeze(-1) if is_vector else solution, factors, rows, success


def sweep(writer: Writer, kind: Kind, nominal: Array, normals: Array, *others: Any) -> Array:
    """The sweeps of a quadratic programme: :func:`aicon_torch.safety.quadratic_programme.swept`."""
    *arrays, sweeps = others
    rows, size = normals.shape[-2:]
    leading = nominal.shape[:-1]
    result = np.empty((*leading, 2 * size), dtype=object)

    own = (1, 2, 1, 1, 1, 1, 2)  # dimensions of each without the batch
    given = [
        np.broadcast_to(array, (*leading, *array.shape[array.ndim - count :]))
        for array, count in zip((nominal, normals, *arrays), own, strict=True)
    ]
    for place in np.ndindex(leading):
        # One flat argument for each robot, in the order in which the routine reads it.
        numbers = [number for array in given for number in writer.cast(array[place], "real").flat]
        call = writer.program.call("sweep", numbers, (rows, size, sweeps, 2 * size))
        result[place] = [writer.program.item(call, index) for index in range(2 * size)]
    return result


def factorize(writer: Writer, kind: Kind, matrix: Array, **_: Any) -> tuple[Array, ...]:
    """L and U in one ``(..., n, n)``, the rows exchanged ``(..., n)``, and 0 for success."""
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
    return factors, rows, writer.full(matrix.shape[:-2], 0, "int")


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
    solution = np.empty((*factors.shape[:-2], size, columns), dtype=object)
    right = np.broadcast_to(right, solution.shape)
    for place in np.ndindex(factors.shape[:-2]):
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
    "swept": sweep,
}
"""The translation of each operator that solves, by its name in aten without the overload."""
