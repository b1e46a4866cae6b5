"""The functions that are written out in C are exact to a few units in the last place."""

import ctypes
import math
from collections.abc import Callable
from typing import Any

import mpmath  # torch brings it
import numpy as np
import pytest
from numpy.typing import NDArray

from aicon_torch.export.codegen import compile_library, has_compiler
from aicon_torch.export.codegen.functions import FUNCTIONS
from aicon_torch.export.codegen.scalars import OPERATIONS

pytestmark = pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")

Vector = NDArray[np.float64]

# Function, its name in mpmath, units in the last place, ranges of its arguments.
ACCURATE = [
    ("exp", "exp", 1, [(-700, 700), (-1, 1), (-0.01, 0.01)]),
    ("expm1", "expm1", 4, [(-30, 30), (-1, 1), (-1e-3, 1e-3)]),
    ("log", "log", 1, [(1e-300, 1e-290), (0.5, 2), (0.99, 1.01), (1, 1e10)]),
    ("log1p", "log1p", 2, [(-0.9, 1), (-1e-3, 1e-3), (0, 1e6)]),
    ("sin", "sin", 1, [(-1000, 1000), (-4, 4), (-0.1, 0.1)]),
    ("cos", "cos", 1, [(-1000, 1000), (-4, 4)]),
    ("tan", "tan", 3, [(-100, 100), (-1, 1)]),
    ("asin", "asin", 3, [(-1, 1), (0.999, 1)]),
    ("acos", "acos", 3, [(-1, 1), (0.999, 1)]),
    ("atan", "atan", 3, [(-100, 100), (-1, 1)]),
    ("sinh", "sinh", 3, [(-10, 10), (-0.1, 0.1)]),
    ("cosh", "cosh", 3, [(-10, 10)]),
    ("tanh", "tanh", 3, [(-10, 10), (-0.1, 0.1)]),
    ("erf", "erf", 15, [(-6, 6), (-0.5, 0.5)]),
    ("atan2", "atan2", 3, [(-1, 1), (-100, 100)]),
    ("hypot", "hypot", 2, [(-1, 1), (1e-300, 1e-290)]),
    ("pow", "power", 20, [(0, 3)]),
]
EXACT = {"floor": np.floor, "ceil": np.ceil, "round": np.rint, "trunc": np.trunc}
AT_THE_EDGES = {
    **{"exp": np.exp, "expm1": np.expm1, "log": np.log, "log1p": np.log1p, "tanh": np.tanh},
    **{"asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "sinh": np.sinh, "cosh": np.cosh},
    **{"atan2": np.arctan2, "hypot": np.hypot, "pow": np.power, "sin": np.sin, "cos": np.cos},
}
EDGES = [0.0, 1.0, 0.5, 2.0, 3.0, 708.0, 746.0, 1e6, 1e308, 5e-324, 2.0**52 - 0.5, math.inf]

SIZE = 150


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    """Every function of arrays, by the name of its operation."""
    pieces = ["#include <math.h>\n", FUNCTIONS]
    texts = {name: OPERATIONS[name].text for name, *_ in ACCURATE}
    texts |= {name: OPERATIONS[name].text for name in EXACT} | {"fmod": "rest_of({0}, {1})"}
    for name, text in texts.items():
        call = text.format("x[i]", "y[i]")
        pieces.append(
            '__attribute__((visibility("default")))'
            f" void each_{name}(long n, const double *x, const double *y, double *result) {{"
            f" for (long i = 0; i < n; ++i) result[i] = {call}; }}\n"
        )
    path = tmp_path_factory.mktemp("functions") / "functions.so"
    compile_library("".join(pieces), path)
    return ctypes.CDLL(str(path))


def values(library: ctypes.CDLL, name: str, *arguments: Vector) -> Vector:
    """A function of arrays."""
    x, y = np.ascontiguousarray(arguments[0]), np.ascontiguousarray(arguments[-1])
    result = np.empty_like(x)
    function = getattr(library, f"each_{name}")
    function.argtypes = [ctypes.c_long, *(3 * [ctypes.c_void_p])]
    function(x.size, x.ctypes.data, y.ctypes.data, result.ctypes.data)
    return result


def exact(name: str, *arguments: Vector) -> list[Any]:
    """The same in 200 bits."""
    function = getattr(mpmath, name)
    with mpmath.workprec(200):
        return [function(*map(mpmath.mpf, map(float, row))) for row in zip(*arguments, strict=True)]


@pytest.mark.parametrize(("name", "oracle", "units", "ranges"), ACCURATE)
def test_they_are_accurate(
    name: str, oracle: str, units: int, ranges: list[tuple[float, float]], library: ctypes.CDLL
) -> None:
    generator = np.random.default_rng(0)
    count = 2 if "{1}" in OPERATIONS[name].text else 1
    for low, high in ranges:
        arguments = [generator.uniform(low, high, size=SIZE) for _ in range(count)]
        found, expected = values(library, name, *arguments), exact(oracle, *arguments)
        for value, truth in zip(found, expected, strict=True):
            assert abs(mpmath.mpf(float(value)) - truth) <= units * math.ulp(float(truth))


@pytest.mark.parametrize(("name", "oracle"), AT_THE_EDGES.items())
def test_they_are_what_numpy_says_at_the_edges(
    name: str, oracle: Callable[..., Vector], library: ctypes.CDLL
) -> None:
    one = np.array([*EDGES, *(-edge for edge in EDGES), math.nan])
    if name in ("sin", "cos"):
        one = one[~(np.abs(one) > 1e6) | np.isinf(one)]  # what is larger is no angle
    arguments = [one]
    if "{1}" in OPERATIONS[name].text:
        arguments = [part.ravel() for part in np.meshgrid(one, one)]

    with np.errstate(all="ignore"):
        found, expected = values(library, name, *arguments), oracle(*arguments)
    np.testing.assert_allclose(found, expected, rtol=1e-10, atol=0.0)
    there = ~np.isnan(expected)
    np.testing.assert_array_equal(np.signbit(found[there]), np.signbit(expected[there]))


@pytest.mark.parametrize(("name", "oracle"), EXACT.items())
def test_integers_nearby_are_exact(
    name: str, oracle: Callable[..., Vector], library: ctypes.CDLL
) -> None:
    x = np.concatenate([any_numbers(0), np.arange(-10, 10) / 2, EDGES, np.negative(EDGES)])
    found, expected = values(library, name, x), oracle(x)
    np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(np.signbit(found), np.signbit(expected))


def test_the_rest_of_a_division_is_exact(library: ctypes.CDLL) -> None:
    x, y = any_numbers(1)[:4000], any_numbers(2)[:4000]
    for numerator, denominator in ((x, y), (np.arange(-30.0, 30.0), np.full(60, 7.0))):
        found = values(library, "fmod", numerator, denominator)
        np.testing.assert_array_equal(found, np.fmod(numerator, denominator))


def any_numbers(seed: int) -> Vector:
    """Numbers of any size that are finite."""
    bits = np.random.default_rng(seed).integers(-(2**63), 2**63 - 1, size=5000)
    numbers = bits.view(np.float64)
    return numbers[np.isfinite(numbers)]
