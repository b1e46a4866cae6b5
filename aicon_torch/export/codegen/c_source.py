"""A program of numbers as a function in C."""

from collections.abc import Collection, Iterable, Mapping, Sequence

import numpy as np
import torch

from aicon_torch.export.codegen.arrays import Array
from aicon_torch.export.codegen.functions import FUNCTIONS
from aicon_torch.export.codegen.scalars import (
    CONSTANT,
    INPUT,
    ITEM,
    OPERATIONS,
    PICK,
    Number,
    Program,
)
from aicon_torch.export.codegen.solving import ROUTINES
from aicon_torch.export.codegen.splitting import numbers_behind, roots_of, split_by

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
static inline int is_above(real a, real b) {{ return a > b || (a != a && b == b); }}
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
    return "\n".join(
        [
            f"static void {name}({_parameters(inputs, outputs)}) {{",
            *_statements(program, numbers_behind(program, roots_of(outputs))),
            *_assignments(outputs, program),
            "}\n",
        ]
    )


def repeated_function(
    name: str,
    program: Program,
    inputs: Sequence[str],
    outputs: Mapping[str, Array],
    varying: Collection[str],
) -> str:
    """A function that is called many times, in two: what stays the same is computed once.

    ``void name_once(const real *input, …, struct name_kept *kept)`` computes what does not depend
    on the varying inputs, ``void name(const real *input, …, const struct name_kept *kept, real
    *output, …)`` the rest, and each operation is in one of them.

    Args:
        name: Its name.
        program: The program that computes the outputs.
        inputs: The names of its inputs.
        outputs: The numbers of each output, which are written as real ones.
        varying: The names of inputs that differ from call to call.
    """
    split = split_by(program, outputs, varying)
    members = [f"{TYPES[number.kind]} v{number.index};" for number in split.kept]
    keep = [f"  kept->v{number.index} = {_text(number, program)};" for number in split.kept]
    recall = [
        f"  const {TYPES[number.kind]} v{number.index} = kept->v{number.index};"
        for number in split.kept
    ]

    fixed = [input for input in inputs if input not in varying]
    kept = f"struct {name}_kept *restrict kept"
    return "\n".join(
        [
            f"struct {name}_kept {{ {' '.join(members)} }};",
            f"static void {name}_once({_parameters(fixed, (), kept)}) {{",
            *_statements(program, split.once),
            *keep,
            "}\n",
            f"static void {name}({_parameters(inputs, outputs, f'const {kept}')}) {{",
            *recall,
            *_statements(program, split.each_time),
            *_assignments(outputs, program),
            "}\n",
        ]
    )


def _parameters(inputs: Iterable[str], outputs: Iterable[str], *between: str) -> str:
    """The parameters of a function."""
    given = [f"const real *restrict {input}" for input in inputs]
    found = [f"real *restrict {output}" for output in outputs]
    return ", ".join([*given, *between, *found])


def _statements(program: Program, needed: Collection[int]) -> list[str]:
    """What computes some numbers, in the order of the program."""
    lines: list[str] = []
    for number in program.numbers:
        if number.index in needed and number.operation != CONSTANT:
            lines += _statement(number, program)
    return lines


def _assignments(outputs: Mapping[str, Array], program: Program) -> list[str]:
    """What writes the outputs."""
    lines = []
    for output, numbers in outputs.items():
        for place, number in enumerate(numbers.reshape(-1)):
            lines.append(f"  {output}[{place}] = {_text(number, program)};")
    return lines


def _statement(number: Number, program: Program) -> list[str]:
    """What computes a number, or calls a routine."""
    arguments = [_text(argument, program) for argument in number.arguments]
    name = f"v{number.index}"
    if number.operation in ROUTINES:
        return _call(number, name, arguments)
    if number.operation == PICK:
        return _lookup(number, name, *arguments)

    if number.operation == INPUT:
        value = f"{number.value[0]}[{number.value[1]}]"
    elif number.operation == ITEM:
        value = f"{arguments[0]}[{number.value}]"
    else:
        suffix = _suffix(program)
        value = OPERATIONS[number.operation].text.format(*arguments, f=suffix)
    return [f"  const {TYPES[number.kind]} {name} = {value};"]


def _lookup(number: Number, name: str, index: str, *candidates: str) -> list[str]:
    """One of an array of candidates."""
    kind, count = TYPES[number.kind], len(candidates)
    place = f"(unsigned long long){index} < {count} ? {index} : 0"
    return [
        f"  const {kind} {name}_of[] = {{{', '.join(candidates)}}};",
        f"  const {kind} {name} = {name}_of[{place}];",
    ]


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


def _text(number: Number, program: Program) -> str:
    """A number as an argument."""
    if number.operation == CONSTANT:
        return _literal(number, _suffix(program))
    return f"v{number.index}"


def _suffix(program: Program) -> str:
    """The suffix of functions and literals of the program's precision."""
    return "f" if program.dtype == torch.float32 else ""


def _literal(number: Number, suffix: str) -> str:
    """A constant, to the last digit."""
    if number.kind != "real":
        return str(int(number.value))
    value = float(number.value)
    if not np.isfinite(value):
        return "((real)NAN)" if np.isnan(value) else f"({'-' if value < 0 else ''}(real)INFINITY)"
    text = f"{value!r}{suffix}"
    return f"({text})" if value < 0 or text.startswith("-") else text
