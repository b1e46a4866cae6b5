"""A function in two, of what stays the same and what varies, computes the same to the last bit."""

import ctypes
from collections.abc import Callable
from pathlib import Path

import pytest
import torch
from _inputs import normal
from torch import Tensor

from aicon_torch.export.codegen import compile_library, has_compiler, in_c, prelude

pytestmark = pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")

SIZE = 9

EXPORTED = """
__attribute__((visibility("default"))) void f_whole(const real *x, const real *y, real *z) {
  whole(x, y, z);
}
__attribute__((visibility("default"))) void f_in_two(const real *x, const real *y, real *z) {
  struct parted_kept kept;
  parted_once(x, &kept);
  for (int k = 0; k < 3; ++k) parted(x, y, &kept, z);
}
"""


def arithmetic(x: Tensor, y: Tensor) -> Tensor:
    """Numbers that are handed on."""
    return x.exp() * y + x.square().sum() / y


def choices(x: Tensor, y: Tensor) -> Tensor:
    """Truth values and indices that are handed on."""
    index = x[:4].argmax(-1, keepdim=True)
    return torch.where(x > 0.3, y, x) + y.gather(0, index)


def solutions(x: Tensor, y: Tensor) -> Tensor:
    """What a routine found that is handed on, and another one that varies."""
    matrix = x.reshape(3, 3) + 3.0 * torch.eye(3, dtype=x.dtype)
    fixed = torch.linalg.solve_ex(matrix, x[:3]).result
    varying = torch.linalg.solve_ex(matrix, y[:3]).result
    return torch.cat((fixed * y[:3], varying, fixed))


def constants(x: Tensor, y: Tensor) -> Tensor:
    """Outputs that do not vary, that are constants, and that are inputs."""
    return torch.cat((x.sin(), torch.ones_like(y), x, y))


@pytest.mark.parametrize(
    "dtype", [torch.float64, pytest.param(torch.float32, marks=pytest.mark.slow)], ids=str
)
@pytest.mark.parametrize("function", [arithmetic, choices, solutions, constants])
def test_a_function_in_two_gives_the_same_bits(
    function: Callable[[Tensor, Tensor], Tensor], dtype: torch.dtype, tmp_path: Path
) -> None:
    def flat(x: Tensor, y: Tensor) -> tuple[Tensor, ...]:
        return (function(x, y).flatten(),)

    # Both forms, in one library.
    examples = {name: normal(SIZE, seed=9).to(dtype) for name in ("x", "y")}
    pieces = [prelude(dtype), in_c("whole", flat, ["x", "y"], ["z"], examples)]
    pieces += [in_c("parted", flat, ["x", "y"], ["z"], examples, varying=["y"]), EXPORTED]
    compile_library("".join(pieces), tmp_path / "f.so")
    library = ctypes.CDLL(str(tmp_path / "f.so"))

    for seed in range(5):
        x, y = (normal(SIZE, seed=seed + offset).to(dtype) for offset in (0, 100))
        found = []
        for name in ("f_whole", "f_in_two"):
            z = torch.empty_like(flat(x, y)[0])
            pointers = [ctypes.c_void_p(values.data_ptr()) for values in (x, y, z)]
            getattr(library, name)(*pointers)
            found.append(z)
        assert found[0].numpy().tobytes() == found[1].numpy().tobytes()


def test_what_stays_the_same_is_computed_in_one_of_the_two_only() -> None:
    def flat(x: Tensor, y: Tensor) -> tuple[Tensor, ...]:
        return (x.sin() * y,)

    examples = {name: normal(1) for name in ("x", "y")}
    once, each_time = in_c("f", flat, ["x", "y"], ["z"], examples, varying=["y"]).split("void f(")
    assert "sine" in once
    assert "sine" not in each_time
