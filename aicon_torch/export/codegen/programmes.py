"""Quadratic programmes as calls of routines: the nearest action that keeps linear bounds."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from aicon_torch.export.codegen.arrays import Array, Writer
from aicon_torch.export.codegen.operators import Translation
from aicon_torch.export.codegen.scalars import Kind
from aicon_torch.safety.active_set import DEPENDENT, FALLS, MISSED, MOST

ROUTINES = {
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
    "exactly": f"""\
/* The row that is missed most, of m rows of n components; -1 where all are kept. */
static int most_missed(int m, int n, const real *normals, const real *bounds, const double *action,
                       double largest) {{
  int row = -1;
  double most = 0;
  for (int i = 0; i < m; ++i) {{
    double missing = bounds[i];
    for (int k = 0; k < n; ++k) missing -= normals[i * n + k] * action[k];
    if (missing > {MISSED} * (fabs(bounds[i]) + largest) && missing > most)
      most = missing, row = i;
  }}
  return row;
}}

/* What of a direction lies along each of some axes, and what stands apart from them: taken twice,
   against rounding. Returns the square of the latter. */
static double taken_apart(int count, int n, const double *axes, const double *direction,
                          double *along, double *apart) {{
  double square = 0;
  for (int i = 0; i < count; ++i) along[i] = 0;
  for (int k = 0; k < n; ++k) apart[k] = direction[k];
  for (int again = 0; again < 2; ++again)
    for (int i = 0; i < count; ++i) {{
      double share = 0;
      for (int k = 0; k < n; ++k) share += axes[i * n + k] * apart[k];
      for (int k = 0; k < n; ++k) apart[k] -= share * axes[i * n + k];
      along[i] += share;
    }}
  for (int k = 0; k < n; ++k) square += apart[k] * apart[k];
  return square;
}}

/* K of the inverse of the metric, K K', below the diagonal and on it. Returns whether the metric is
   positive definite. */
static int root_of(int n, const real *inverse, double *root) {{
  for (int i = 0; i < n; ++i)
    for (int j = 0; j <= i; ++j) {{
      double rest = inverse[i * n + j];
      for (int k = 0; k < j; ++k) rest -= root[i * n + k] * root[j * n + k];
      if (i == j && !(rest > 0)) return 0;
      root[i * n + j] = i == j ? sqrt(rest) : rest / root[j * n + j];
    }}
  return 1;
}}

/* The dual active-set method for m rows of length one and n components in a metric, in double
   precision: x has w, the rows' normals and bounds, and the inverse of the metric; y gets the
   action and the force of the bounds, or w and 0 where no action keeps them all.

   Row i of `turned` is K' times the normal of the i-th active row, and after them comes the one
   that is to join them. Their axes are orthonormal: turned = factors axes. */
static void exactly(int m, int n, const real *x, real *y) {{
  const real *normals = x + n, *bounds = normals + m * n, *inverse = bounds + m;
  double turned[(n + 1) * n], axes[(n + 1) * n], factors[(n + 1) * n], multipliers[n + 1];
  double action[n], apart[n], shares[n], root[n * n], largest = 0;
  int rows[n + 1], active = 0, is_kept = root_of(n, inverse, root), row = -1;
  for (int k = 0; k < n; ++k) action[k] = x[k];

  for (int turn = 0; turn < {MOST} && is_kept; ++turn) {{
    for (int k = 0; k < n; ++k) largest = fabs(action[k]) > largest ? fabs(action[k]) : largest;
    row = most_missed(m, n, normals, bounds, action, largest);
    if (row < 0) break;

    const real *normal = normals + row * n;
    double missing = bounds[row], square = 0;
    for (int k = 0; k < n; ++k) {{
      missing -= normal[k] * action[k];
      double sum = 0;
      for (int j = k; j < n; ++j) sum += normal[j] * root[j * n + k];
      turned[active * n + k] = sum;
      square += sum * sum;
    }}
    rows[active] = row;
    multipliers[active] = 0;

    for (int is_full = 0; !is_full && is_kept;) {{
      /* Along its own direction the active rows would leave their bounds: what stands apart from
         them does not. A share of each takes the rest back. */
      double *along = factors + active * n;
      double effect = taken_apart(active, n, axes, turned + active * n, along, apart);
      for (int i = active - 1; i >= 0; --i) {{
        shares[i] = along[i];
        for (int k = i + 1; k < active; ++k) shares[i] -= factors[k * n + i] * shares[k];
        shares[i] /= factors[i * n + i];
      }}

      /* How far until the row is kept, and how far until a multiplier comes to zero. */
      int is_free = effect > {DEPENDENT} * square, let_go = -1;
      double step = is_free ? missing / effect : INFINITY;
      for (int i = 0; i < active; ++i)
        if (shares[i] > {FALLS} && multipliers[i] / shares[i] < step)
          step = multipliers[i] / shares[i], let_go = i;
      is_kept = step < INFINITY;
      is_full = is_kept && let_go < 0;
      if (!is_kept) break;

      for (int k = 0; is_free && k < n; ++k)
        for (int j = 0; j <= k; ++j) action[k] += step * root[k * n + j] * apart[j];
      if (is_free) missing -= step * effect;
      for (int i = 0; i < active; ++i) multipliers[i] -= step * shares[i];
      multipliers[active] += step;

      /* It joins them; or one of them is let go, and those after it get axes anew. */
      if (is_full) {{
        along[active] = sqrt(effect);
        for (int k = 0; k < n; ++k) axes[active * n + k] = apart[k] / along[active];
        continue;
      }}
      for (int i = let_go; i < active; ++i) {{
        rows[i] = rows[i + 1], multipliers[i] = multipliers[i + 1];
        for (int k = 0; k < n; ++k) turned[i * n + k] = turned[(i + 1) * n + k];
      }}
      --active;
      for (int i = let_go; i < active; ++i) {{
        along = factors + i * n;
        along[i] = sqrt(taken_apart(i, n, axes, turned + i * n, along, apart));
        for (int k = 0; k < n; ++k) axes[i * n + k] = apart[k] / along[i];
      }}
    }}
    active += is_kept;
  }}
  for (int k = 0; k < n; ++k) {{
    double force = 0;
    for (int i = 0; i < active; ++i) force += multipliers[i] * normals[rows[i] * n + k];
    y[k] = row < 0 ? action[k] : x[k], y[n + k] = row < 0 ? force : 0;
  }}
}}
""",
}
"""The routines in C."""


def sweep(writer: Writer, kind: Kind, nominal: Array, normals: Array, *others: Any) -> Array:
    """The sweeps of a quadratic programme: :func:`aicon_torch.safety.hildreth.swept`."""
    *arrays, sweeps = others
    return _found(writer, "sweep", (nominal, normals, *arrays), (1, 2, 1, 1, 1, 1, 2), (sweeps,))


def exactly(writer: Writer, kind: Kind, *arrays: Array) -> Array:
    """The solution of a quadratic programme: :func:`aicon_torch.safety.active_set.exactly`."""
    return _found(writer, "exactly", arrays, (1, 2, 1, 2), ())


def _found(
    writer: Writer,
    routine: str,
    arrays: Sequence[Array],
    dimensions: Sequence[int],
    more: tuple[int, ...],
) -> Array:
    """The action and the force of the bounds, ``(*B, 2 n)``.

    Args:
        writer: Writes into the program.
        routine: Which one is called.
        arrays: What it reads, in this order: w and the rows' normals first.
        dimensions: How many each of them has without the batch.
        more: Numbers that it is told besides those of rows and components.
    """
    nominal, normals, *_ = arrays
    leading, (rows, size) = nominal.shape[:-1], normals.shape[-2:]
    result = np.empty((*leading, 2 * size), dtype=object)
    given = [
        np.broadcast_to(array, (*leading, *array.shape[array.ndim - count :]))
        for array, count in zip(arrays, dimensions, strict=True)
    ]
    for place in np.ndindex(leading):
        # One flat argument for each robot, in the order in which the routine reads it.
        numbers = [number for array in given for number in writer.cast(array[place], "real").flat]
        call = writer.program.call(routine, numbers, (rows, size, *more, 2 * size))
        result[place] = [writer.program.item(call, index) for index in range(2 * size)]
    return result


PROGRAMMES: dict[str, Translation] = {"aicon::swept": sweep, "aicon::exactly": exactly}
