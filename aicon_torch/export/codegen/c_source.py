"""A program of numbers as a function in C."""

from collections.abc import Mapping, Sequence

import numpy as np
import torch

from aicon_torch.export.codegen.arrays import Array
from aicon_torch.export.codegen.functions import FUNCTIONS
from aicon_torch.export.codegen.scalars import CONSTANT, INPUT, ITEM, OPERATIONS, Number, Program
from aicon_torch.export.codegen.solving import ROUTINES

TYPES = {"real": "real", "int": "integer", "bool": "int"}
"""The type of each kind of number in C."""


def prelude(dtype: torch.dtype) -> str:
    """What every function needs: the types, and operations that C does not have.

    Args:
        dtype: The precision of real numbers.
    """
    is_single = dtype == torch.float32
    name, suffix = ("float", "f") if is_single else ("double", "")
    return f"""\
#include <math.h>

typedef {name} real;
typedef long long integer;

static inline real magnitude(real a) {{ return fabs{suffix}(a); }}
static inline real larger(real a, real b) {{ return (a > b || a != a) ? a : b; }}
static inline real smaller(real a, real b) {{ return (a < b || a != a) ? a : b; }}
{FUNCTIONS}
static inline real modulo(real a, real b) {{
  real rest = rest_of(a, b);
  return (rest != 0 && (rest < 0) != (b < 0)) ? rest + b : rest;
}}

{"".join(ROUTINES.values())}"""


def function(
    name: str, program: Program, inputs: Sequence[str], outputs: Mapping[str, Array]
) -> str:
    """A function ``void name(const real *input, …, real *output, …)``.

    Args:
        name: Its name.
        program: The program that computes the outputs.
        inputs: The names of its inputs.
        outputs: The numbers of each output, which are written as real ones.
    """
    parameters = [f"const real *restrict {input}" for input in inputs]
    parameters += [f"real *restrict {output}" for output in outputs]
    lines = [f"static void {name}({', '.join(parameters)}) {{"]

    # What the outputs depend on, in the order of the program.
    needed = _needed(program, outputs)
    suffix = "f" if program.dtype == torch.float32 else ""
    for number in program.numbers:
        if number.index in needed and number.operation not in (CONSTANT, ITEM):
            lines += _statement(number, suffix)

    for output, numbers in outputs.items():
        for place, number in enumerate(numbers.reshape(-1)):
            lines.append(f"  {output}[{place}] = {_text(number, suffix)};")
    return "\n".join([*lines, "}", ""])


def _needed(program: Program, outputs: Mapping[str, Array]) -> set[int]:
    """The numbers that some output depends on."""
    needed: set[int] = set()
    for numbers in outputs.values():
        needed.update(number.index for number in numbers.reshape(-1))
    for number in reversed(program.numbers):
        if number.index in needed:
            needed.update(argument.index for argument in number.arguments)
    return needed


def _statement(number: Number, suffix: str) -> list[str]:
    """What computes a number, or calls a routine."""
    arguments = [_text(argument, suffix) for argument in number.arguments]
    name = f"v{number.index}"
    if number.operation in ROUTINES:
        return _call(number, name, arguments)
    if number.operation == INPUT:
        value = f"{number.value[0]}[{number.value[1]}]"
    else:
        value = OPERATIONS[number.operation].text.format(*arguments, f=suffix)
    return [f"  const {TYPES[number.kind]} {name} = {value};"]


def _call(number: Number, name: str, arguments: Sequence[str]) -> list[str]:
    """The call of a routine, whose arguments and results are arrays."""
    *sizes, count = number.value
    given = f"  const real {name}_in[] = {{{', '.join(arguments)}}};"
    result = f"  real {name}[{count}];"

    pointers = f"{name}_in"
    if number.operation.startswith("substitute"):
        size = sizes[0]
        pointers = f"{name}_in, {name}_in + {size * size}, {name}_in + {size * size + size}"
    numbers = ", ".join(str(size) for size in sizes)
    return [given, result, f"  {number.operation}({numbers}, {pointers}, {name});"]


def _text(number: Number, suffix: str) -> str:
    """A number as an argument."""
    if number.operation == CONSTANT:
        return _literal(number, suffix)
    if number.operation == ITEM:
        return f"v{number.arguments[0].index}[{number.value}]"
    return f"v{number.index}"


def _literal(number: Number, suffix: str) -> str:
    """A constant, to the last digit."""
    if number.kind != "real":
        return str(int(number.value))
    value = float(number.value)
    if not np.isfinite(value):
        return "((real)NAN)" if np.isnan(value) else f"({'-' if value < 0 else ''}(real)INFINITY)"
    text = f"{value!r}{suffix}"
    return f"({text})" if value < 0 or text.startswith("-") else text
