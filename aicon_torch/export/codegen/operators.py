"""What each operator of a traced graph does to the numbers of its tensors, element by element.

A translation takes a :class:`~aicon_torch.export.codegen.arrays.Writer`, the kind of its result and
the operator's arguments, with an array of numbers in place of each tensor.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from aicon_torch.export.codegen.arrays import Array, Writer
from aicon_torch.export.codegen.scalars import Kind

Translation = Callable[..., Any]
"""From a writer, a kind and an operator's arguments to an array, or to several."""


def elementwise(operation: str) -> Translation:
    """The translation of an operator that is an elementary operation itself."""

    def translation(writer: Writer, kind: Kind, *values: Any) -> Array:
        return writer.map(operation, kind, *values)

    return translation


def bitwise(operation: str) -> Translation:
    """The translation of an operator on truth values, which of integers is another one."""

    def translation(writer: Writer, kind: Kind, *values: Any) -> Array:
        if kind != "bool":
            raise NotImplementedError("bit by bit, of integers")
        return writer.map(operation, kind, *values)

    return translation


def scaled(operation: str) -> Translation:
    """The translation of a sum or a difference, whose second term torch may scale by alpha."""

    def translation(writer: Writer, kind: Kind, first: Any, second: Any, alpha: float = 1) -> Array:
        if alpha != 1:
            second = writer.map("mul", kind, second, alpha)
        chosen = "or" if kind == "bool" else operation  # true and true is true, not 2
        return writer.map(chosen, kind, first, second)

    return translation


def divide(
    writer: Writer, kind: Kind, first: Any, second: Any, rounding_mode: str | None = None
) -> Array:
    """Quotient, rounded if asked."""
    if rounding_mode == "floor":
        return writer.map("floor_divide", kind, first, second)
    quotient = writer.map("div", "real", first, second)
    if rounding_mode is None:
        return quotient
    return writer.cast(writer.map(rounding_mode, "real", quotient), kind)


def power(writer: Writer, kind: Kind, base: Any, exponent: Any) -> Array:
    """Power; the common ones as products and roots."""
    if isinstance(exponent, np.ndarray):  # of each number its own
        return writer.map("pow", kind, base, exponent)
    if exponent == 1:
        return writer.array(base, kind)
    if exponent == 2:
        return writer.map("mul", kind, base, base)
    if exponent == 0.5:
        return writer.map("sqrt", kind, base)
    if exponent == -0.5:
        return inverse_root(writer, kind, base)
    if kind == "int" and 2 < exponent < 64:  # exact, as far as integers go
        return writer.map("mul", kind, base, power(writer, kind, base, exponent - 1))
    return writer.map("pow", kind, base, exponent)


def reciprocal(writer: Writer, kind: Kind, value: Any) -> Array:
    """1 / x."""
    return writer.map("div", kind, 1.0, value)


def inverse_root(writer: Writer, kind: Kind, value: Any) -> Array:
    """1 / √x."""
    return reciprocal(writer, kind, writer.map("sqrt", kind, value))


def sigmoid(writer: Writer, kind: Kind, value: Any) -> Array:
    """1 / (1 + exp(−x))."""
    # Far below zero exp(−x) is infinite, and its reciprocal 0, as it should be.
    growth = writer.map("exp", kind, writer.map("neg", kind, value))
    return reciprocal(writer, kind, writer.map("add", kind, 1.0, growth))


def rectify(writer: Writer, kind: Kind, value: Any) -> Array:
    """max(x, 0)."""
    return writer.map("maximum", kind, value, 0)


def sign(writer: Writer, kind: Kind, value: Any) -> Array:
    """−1, 0 or 1."""
    is_above, is_below = writer.map("gt", "bool", value, 0), writer.map("lt", "bool", value, 0)
    return writer.map("sub", kind, is_above, is_below)


def is_nan(writer: Writer, kind: Kind, value: Any) -> Array:
    """Whether it equals not even itself."""
    return writer.map("ne", kind, value, value)


def is_infinite(writer: Writer, kind: Kind, value: Any) -> Array:
    """Whether it is infinite, of either sign."""
    return writer.map("eq", kind, writer.map("abs", "real", value), float("inf"))


def clamp(writer: Writer, kind: Kind, value: Any, low: Any = None, high: Any = None) -> Array:
    """The nearest value within bounds."""
    if low is not None:
        value = writer.map("maximum", kind, value, low)
    if high is not None:
        value = writer.map("minimum", kind, value, high)
    return writer.array(value)


def masked_fill(writer: Writer, kind: Kind, value: Any, mask: Any, filling: Any) -> Array:
    """The value, and something else where a mask is set."""
    return writer.map("where", kind, mask, filling, value)


def convert(writer: Writer, kind: Kind, value: Any, **_: Any) -> Array:
    """A copy, of another kind if asked."""
    return writer.cast(writer.array(value), kind).copy()


# --- sums and the like


def _dims(value: Array, dims: int | Sequence[int] | None) -> Sequence[int]:
    """The dimensions of a reduction; none named means all."""
    if dims is None or dims == []:
        return range(value.ndim)
    return [dims] if isinstance(dims, int) else dims


def reduction(operation: str) -> Translation:
    """The translation of an operator that takes one elementary operation along dimensions."""

    def translation(
        writer: Writer,
        kind: Kind,
        value: Array,
        dims: int | Sequence[int] | None = None,
        keepdim: bool = False,
        **_: Any,
    ) -> Array:
        return writer.reduce(operation, kind, value, _dims(value, dims), keepdim)

    return translation


def mean(
    writer: Writer,
    kind: Kind,
    value: Array,
    dims: int | Sequence[int] | None = None,
    keepdim: bool = False,
    **_: Any,
) -> Array:
    """Mean."""
    total = writer.reduce("add", kind, value, _dims(value, dims), keepdim)
    return writer.map("div", kind, total, float(value.size // max(total.size, 1)))


def variance(
    writer: Writer,
    kind: Kind,
    value: Array,
    dims: int | Sequence[int] | None = None,
    correction: float | None = None,
    keepdim: bool = False,
) -> Array:
    """Σ (x − mean)² / (n − correction); by default the correction is 1."""
    along = _dims(value, dims)
    deviation = writer.map("sub", kind, value, mean(writer, kind, value, dims, keepdim=True))
    squares = writer.map("mul", kind, deviation, deviation)
    total = writer.reduce("add", kind, squares, along, keepdim)

    count = value.size // max(total.size, 1)
    return writer.map("div", kind, total, count - (1.0 if correction is None else correction))


def variance_and_mean(
    writer: Writer,
    kind: Kind,
    value: Array,
    dims: int | Sequence[int] | None = None,
    correction: float | None = None,
    keepdim: bool = False,
) -> tuple[Array, Array]:
    """Both, as the layers of networks take them."""
    spread = variance(writer, kind, value, dims, correction, keepdim)
    return spread, mean(writer, kind, value, dims, keepdim)


def norm(
    writer: Writer,
    kind: Kind,
    value: Array,
    order: float = 2,
    dims: int | Sequence[int] | None = None,
    keepdim: bool = False,
    **_: Any,
) -> Array:
    """Euclidean length, largest magnitude, or sum of magnitudes."""
    along = _dims(value, dims)
    if order == 2:
        squares = writer.map("mul", kind, value, value)
        return writer.map("sqrt", kind, writer.reduce("add", kind, squares, along, keepdim))

    operations = {1: "add", float("inf"): "maximum"}
    if order not in operations:
        raise NotImplementedError(f"of order {order}")
    magnitudes = writer.map("abs", kind, value)
    return writer.reduce(operations[order], kind, magnitudes, along, keepdim)


def softmax(writer: Writer, kind: Kind, value: Array, dim: int, _: bool = False) -> Array:
    """exp(x) over the sum of exp(x), shifted by the largest so that nothing overflows."""
    largest = writer.reduce("maximum", kind, value, [dim], True)
    growth = writer.map("exp", kind, writer.map("sub", kind, value, largest))
    return writer.map("div", kind, growth, writer.reduce("add", kind, growth, [dim], True))


def product_in_lines(writer: Writer, kind: Kind, first: Array, second: Array) -> Array:
    """``(..., n, k)`` times ``(..., k, m)``."""
    # All products (..., n, k, m), then their sum over k.
    terms = writer.map("mul", kind, first[..., :, :, None], second[..., None, :, :])
    return writer.reduce("add", kind, terms, [-2], False)


ELEMENTWISE: dict[str, Translation] = {
    "add": scaled("add"),
    "sub": scaled("sub"),
    "div": divide,
    "pow": power,
    "reciprocal": reciprocal,
    "rsqrt": inverse_root,
    "sigmoid": sigmoid,
    "relu": rectify,
    "sign": sign,
    "isnan": is_nan,
    "isinf": is_infinite,
    "clamp": clamp,
    "masked_fill": masked_fill,
    "_to_copy": convert,
    "clone": convert,
    "lift_fresh_copy": convert,
    "sum": reduction("add"),
    "prod": reduction("mul"),
    "amax": reduction("maximum"),
    "amin": reduction("minimum"),
    "any": reduction("or"),
    "all": reduction("and"),
    "mean": mean,
    "var": variance,
    "var_mean": variance_and_mean,
    "linalg_vector_norm": norm,
    "_softmax": softmax,
}
"""The translation of each operator on numbers, by its name in aten without the overload."""

for _name in (
    *("neg", "abs", "maximum", "minimum", "remainder", "floor", "ceil", "round", "trunc", "mul"),
    *("sqrt", "exp", "expm1", "log", "log1p", "sin", "cos", "tan", "asin", "acos", "atan", "atan2"),
    *("hypot", "sinh", "cosh", "tanh", "erf", "eq", "ne", "lt", "le", "gt", "ge", "where"),
):
    ELEMENTWISE[_name] = elementwise(_name)

# Of truth values the operators bit by bit are the logical ones.
for _name in ("and", "or", "xor", "not"):
    ELEMENTWISE[f"logical_{_name}"] = elementwise(_name)
    ELEMENTWISE[f"bitwise_{_name}"] = bitwise(_name)
