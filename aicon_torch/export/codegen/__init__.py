"""Functions of tensors as plain C: traced, taken apart into numbers, and written out."""

from aicon_torch.export.codegen.c_source import prelude
from aicon_torch.export.codegen.cache import cached_library
from aicon_torch.export.codegen.compiler import compile_library, has_compiler
from aicon_torch.export.codegen.tracing import FlatFunction, in_c

__all__ = ["FlatFunction", "cached_library", "compile_library", "has_compiler", "in_c", "prelude"]
