"""Functions of tensors, translated to C, compiled and loaded."""

import ctypes
from collections.abc import Callable
from pathlib import Path

import torch
from torch import Tensor

from _inputs.random_numbers import normal
from aicon_torch.export.codegen import compile_library, in_c, prelude

Function = Callable[[Tensor], Tensor]

SIZE = 12
EXPORTED = '__attribute__((visibility("default"))) void f('


def translated(function: Function, dtype: torch.dtype, folder: Path) -> Function:
    """The function, translated and compiled."""
    source = source_of(function, dtype)
    compile_library(prelude(dtype) + source.replace("static void f(", EXPORTED), folder / "f.so")
    library = ctypes.CDLL(str(folder / "f.so"))
    count = function(normal(SIZE).to(dtype)).numel()

    def run(x: Tensor) -> Tensor:
        given, found = x.numpy(), torch.empty(count, dtype=dtype).numpy()
        library.f(ctypes.c_void_p(given.ctypes.data), ctypes.c_void_p(found.ctypes.data))
        return torch.from_numpy(found)

    return run


def source_of(function: Function, dtype: torch.dtype = torch.float64) -> str:
    """The function in C."""
    # Traced on numbers of its own: nothing that it decides must be fixed by tracing.
    traced_on = normal(SIZE, seed=9).to(dtype)
    return in_c("f", lambda values: (function(values).flatten(),), ["x"], ["y"], {"x": traced_on})
