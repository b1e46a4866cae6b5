"""Layers of networks, as loops over arrays with weights in tables, not as thousands of lines.

A product with a matrix of constants, a convolution and pooling are calls of routines. What is done
to each number of their results is one loop: an array stays an array until its numbers are needed
one by one.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from aicon_torch.export.codegen.arrays import Array, Writer, as_array
from aicon_torch.export.codegen.operators import Translation, product_in_lines
from aicon_torch.export.codegen.scalars import CONSTANT, Kind, Number

LEAST = 256
"""Numbers of a matrix from which on it is a table; smaller ones are written out, and faster."""

_WINDOW = "int c, int h, int w, int oc, int oh, int ow, int kh, int kw, int sh, int sw, "
_WINDOW += "int ph, int pw, int dh, int dw, int groups"

NETWORK_ROUTINES = {
    "weigh": """\
/* y = W x, for m rows of k weights. */
static void weigh(int m, int k, const real *w, const real *x, real *y) {
  for (int i = 0; i < m; ++i) {
    real sum = w[i * k] * x[0];
    for (int j = 1; j < k; ++j) sum += w[i * k + j] * x[j];
    y[i] = sum;
  }
}
""",
    "add_rows": """\
/* The sum of each row of k numbers, in eight parts that are added up side by side. */
static void add_rows(int k, int m, const real *x, real *y) {
  for (int i = 0; i < m; ++i, x += k) {
    real part[8] = {0};
    int whole = k - k % 8;
    for (int j = 0; j < whole; j += 8)
      for (int p = 0; p < 8; ++p) part[p] += x[j + p];
    for (int j = whole; j < k; ++j) part[j - whole] += x[j];
    y[i] = ((part[0] + part[1]) + (part[2] + part[3])) +
           ((part[4] + part[5]) + (part[6] + part[7]));
  }
}
""",
    "maximum_rows": """\
/* The largest number of each row of k. */
static void maximum_rows(int k, int m, const real *x, real *y) {
  for (int i = 0; i < m; ++i) {
    real best = x[i * k];
    for (int j = 1; j < k; ++j) best = larger(best, x[i * k + j]);
    y[i] = best;
  }
}
""",
    "convolve": f"""\
/* Images (oc, oh, ow) of images (c, h, w) by kernels (oc, c / groups, kh, kw), then oc biases. */
static void convolve({_WINDOW},
                     const real *weights, const real *x, real *y) {{
  for (int o = 0; o < oc; ++o) {{
    int first = o / (oc / groups) * (c / groups);
    real *out = y + o * oh * ow;
    for (int n = 0; n < oh * ow; ++n) out[n] = weights[oc * (c / groups) * kh * kw + o];
    for (int p = 0; p < c / groups; ++p)
      for (int u = 0; u < kh; ++u)
        for (int v = 0; v < kw; ++v) {{
          real weight = weights[((o * (c / groups) + p) * kh + u) * kw + v];
          int shift = v * dw - pw;
          int left = shift < 0 ? (sw - 1 - shift) / sw : 0;
          int right = shift < w ? (w - 1 - shift) / sw + 1 : 0;
          if (right > ow) right = ow;
          for (int i = 0; i < oh; ++i) {{
            int row = i * sh - ph + u * dh;
            if (row < 0 || row >= h) continue;
            const real *in = x + ((first + p) * h + row) * w;
            for (int j = left; j < right; ++j) out[i * ow + j] += weight * in[j * sw + shift];
          }}
        }}
  }}
}}
""",
    "convolve_back": f"""\
/* What a gradient of a convolution's result (oc, oh, ow) is by its images (c, h, w). */
static void convolve_back({_WINDOW},
                          const real *weights, const real *g, real *x) {{
  for (int n = 0; n < c * h * w; ++n) x[n] = 0;
  for (int o = 0; o < oc; ++o)
    for (int i = 0; i < oh; ++i)
      for (int j = 0; j < ow; ++j) {{
        int first = o / (oc / groups) * (c / groups);
        for (int p = 0; p < c / groups; ++p)
          for (int u = 0; u < kh; ++u)
            for (int v = 0; v < kw; ++v) {{
              int row = i * sh - ph + u * dh, column = j * sw - pw + v * dw;
              if (row >= 0 && row < h && column >= 0 && column < w)
                x[((first + p) * h + row) * w + column] +=
                    weights[((o * (c / groups) + p) * kh + u) * kw + v]
                    * g[(o * oh + i) * ow + j];
            }}
      }}
}}
""",
    "pool_largest": f"""\
/* The largest number in each window of images (c, h, w). */
static void pool_largest({_WINDOW},
                         const real *x, real *y) {{
  for (int o = 0; o < c; ++o)
    for (int i = 0; i < oh; ++i)
      for (int j = 0; j < ow; ++j) {{
        real best = -INFINITY;
        for (int u = 0; u < kh; ++u)
          for (int v = 0; v < kw; ++v) {{
            int row = i * sh - ph + u * dh, column = j * sw - pw + v * dw;
            if (row >= 0 && row < h && column >= 0 && column < w)
              best = larger(best, x[(o * h + row) * w + column]);
          }}
        y[(o * oh + i) * ow + j] = best;
      }}
}}
""",
    "pool_mean": f"""\
/* The mean of each window of images (c, h, w); what lies beyond them is zero. */
static void pool_mean({_WINDOW},
                      const real *x, real *y) {{
  for (int o = 0; o < c; ++o)
    for (int i = 0; i < oh; ++i)
      for (int j = 0; j < ow; ++j) {{
        real sum = 0;
        for (int u = 0; u < kh; ++u)
          for (int v = 0; v < kw; ++v) {{
            int row = i * sh - ph + u, column = j * sw - pw + v;
            if (row >= 0 && row < h && column >= 0 && column < w)
              sum += x[(o * h + row) * w + column];
          }}
        y[(o * oh + i) * ow + j] = sum / (kh * kw);
      }}
}}
""",
}
"""The routines in C."""


def table_of(writer: Writer, *constants: Array) -> str:
    """The name of a table of constants, one array after the other."""
    numbers = [number for array in constants for number in array.reshape(-1)]
    return writer.program.table([number.value for number in numbers])


def is_table(numbers: Array) -> bool:
    """Whether an array is one of constants, and many."""
    return numbers.size >= LEAST and all(n.operation == CONSTANT for n in numbers.reshape(-1))


def product(writer: Writer, kind: Kind, first: Array, second: Array) -> Array:
    """``(..., n, k)`` times ``(..., k, m)``: a loop where one of them is a table."""
    # The table goes on the left; without one, the product is written out.
    if kind != "real" or (is_table(first) and is_table(second)):
        return product_in_lines(writer, kind, first, second)
    if is_table(second):  # (AB)ᵀ = BᵀAᵀ
        return product(writer, kind, second.swapaxes(-1, -2), first.swapaxes(-1, -2)).swapaxes(
            -1, -2
        )
    if not is_table(first):
        return product_in_lines(writer, kind, first, second)

    # One call for each column of each product: the table times a vector.
    rows, inner = first.shape[-2:]
    leading = np.broadcast_shapes(first.shape[:-2], second.shape[:-2])
    first = np.broadcast_to(first, (*leading, *first.shape[-2:]))
    second = np.broadcast_to(second, (*leading, *second.shape[-2:]))
    result = np.empty((*leading, rows, second.shape[-1]), dtype=object)
    for place in np.ndindex(leading):
        table = table_of(writer, first[place])
        for column in range(second.shape[-1]):
            vector = writer.cast(second[place][:, column], "real")
            sizes = (rows, inner, table)
            result[place][:, column] = _called(writer, "weigh", vector, sizes, (rows,))
    return result


def product_and_sum(writer: Writer, kind: Kind, start: Array, first: Array, second: Array) -> Array:
    """C + AB."""
    return writer.map("add", kind, start, product(writer, kind, first, second))


def convolution(
    writer: Writer,
    kind: Kind,
    image: Array,
    weight: Array,
    bias: Array | None,
    stride: Sequence[int],
    padding: Sequence[int],
    dilation: Sequence[int],
    transposed: bool,
    _: Sequence[int],
    groups: int,
) -> Array:
    """Images ``(n, c, …)`` convolved, of one or two dimensions."""
    _check(weight, bias, transposed)
    window = (stride, padding, dilation, groups)

    # The table has the weights (oc, c / groups, kh, kw), and after them a bias for each channel.
    sizes = _sizes(image.shape, weight.shape, *window)
    biases = writer.full((weight.shape[0],), 0.0, "real") if bias is None else bias
    table = table_of(writer, weight, biases)
    out = (sizes[3], *_shape(image, sizes[4], sizes[5]))
    convolved = [
        _called(writer, "convolve", writer.cast(one, "real"), (*sizes, table), out) for one in image
    ]
    return np.stack(convolved)


def convolution_backward(
    writer: Writer,
    kind: Kind,
    gradient: Array,
    image: Array,
    weight: Array,
    bias_sizes: Any,
    stride: Sequence[int],
    padding: Sequence[int],
    dilation: Sequence[int],
    transposed: bool,
    _: Sequence[int],
    groups: int,
    wanted: Sequence[bool],
) -> tuple[Array | None, None, None]:
    """The gradient by the images; none by weights, which are constants."""
    _check(weight, None, transposed or any(wanted[1:]))
    sizes = _sizes(image.shape, weight.shape, stride, padding, dilation, groups)
    table = table_of(writer, weight)
    found: list[Array] = []
    for one in gradient:
        numbers = writer.cast(one, "real")
        found.append(_called(writer, "convolve_back", numbers, (*sizes, table), image.shape[1:]))
    return np.stack(found), None, None


def largest_in_window(
    writer: Writer,
    kind: Kind,
    image: Array,
    window: Sequence[int],
    stride: Sequence[int] = (),
    padding: Sequence[int] = (0,),
    dilation: Sequence[int] = (1,),
    ceils: bool = False,
) -> tuple[Array, None]:
    """Max pooling of images ``(n, c, h, w)``; where the largest are is not told."""
    return _pooled(writer, "pool_largest", image, window, stride, padding, dilation, ceils), None


def mean_of_window(
    writer: Writer,
    kind: Kind,
    image: Array,
    window: Sequence[int],
    stride: Sequence[int] = (),
    padding: Sequence[int] = (0,),
    ceils: bool = False,
    counts_padding: bool = True,
    divisor: int | None = None,
) -> Array:
    """Mean pooling of images ``(n, c, h, w)``."""
    if divisor is not None or (any(padding) and not counts_padding):
        raise NotImplementedError("where padding does not count")
    return _pooled(writer, "pool_mean", image, window, stride, padding, (1,), ceils)


def _pooled(
    writer: Writer,
    routine: str,
    image: Array,
    window: Sequence[int],
    stride: Sequence[int],
    padding: Sequence[int],
    dilation: Sequence[int],
    ceils: bool,
) -> Array:
    if ceils:
        raise NotImplementedError("with ceil_mode=True")
    channels = image.shape[-3]

    # One number stands for both axes; without a stride, windows stand side by side.
    pair = [tuple(v) * (2 // len(v)) for v in (window, stride or window, padding, dilation)]

    # Each channel is by itself, as in a convolution of as many groups.
    kernel = (channels, 1, *pair[0])
    sizes = _sizes((1, *image.shape[-3:]), kernel, pair[1], pair[2], pair[3], channels)
    images = image.reshape(-1, *image.shape[-3:])
    out = (channels, sizes[4], sizes[5])
    pooled = [_called(writer, routine, writer.cast(one, "real"), sizes, out) for one in images]
    return np.stack(pooled).reshape(*image.shape[:-3], *out)


def _check(weight: Array, bias: Array | None, is_other: bool) -> None:
    if is_other or weight.ndim not in (3, 4):
        raise NotImplementedError("unless it is a plain convolution in one or two dimensions")
    numbers = [*weight.reshape(-1), *(() if bias is None else bias)]
    if not all(number.operation == CONSTANT for number in numbers):
        raise NotImplementedError("unless its weights are constants")


def _sizes(
    image: Sequence[int],
    weight: Sequence[int],
    stride: Sequence[int],
    padding: Sequence[int],
    dilation: Sequence[int],
    groups: int,
) -> tuple[int, ...]:
    """c, h, w, oc, oh, ow, kh, kw, sh, sw, ph, pw, dh, dw and groups; one dimension is a row."""
    if len(image) == 3:
        image, weight = (*image[:2], 1, image[2]), (*weight[:2], 1, weight[2])
        stride, padding, dilation = (1, *stride), (0, *padding), (1, *dilation)
    outer: list[int] = []
    for axis in range(2):
        # How much a dilated kernel covers, and how often it fits at this stride.
        covered = dilation[axis] * (weight[2 + axis] - 1) + 1
        outer.append((image[2 + axis] + 2 * padding[axis] - covered) // stride[axis] + 1)
    shape = (*image[1:], weight[0], *outer, *weight[2:])
    return (*shape, *stride, *padding, *dilation, groups)


def _shape(image: Array, height: int, width: int) -> tuple[int, ...]:
    return (width,) if image.ndim == 3 else (height, width)


def _called(
    writer: Writer, routine: str, numbers: Array, sizes: Sequence[int | str], shape: Sequence[int]
) -> Array:
    """What a routine makes of an array."""
    count = int(np.prod(shape))
    given: list[Number] = list(numbers.reshape(-1))

    # What is in one array already is not gathered into another.
    source = writer.whole(given)
    call = writer.program.call(routine, given if source is None else [source], (*sizes, count))
    items = [writer.program.item(call, place) for place in range(count)]
    return as_array(items, tuple(shape))


NETWORKS: dict[str, Translation] = {
    "mm": product,
    "bmm": product,
    "addmm": product_and_sum,
    "convolution": convolution,
    "convolution_backward": convolution_backward,
    "max_pool2d_with_indices": largest_in_window,
    "avg_pool2d": mean_of_window,
}
"""The translation of each operator of a layer, by its name in aten without the overload."""
