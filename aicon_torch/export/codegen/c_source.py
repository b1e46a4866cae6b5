"""A program of numbers as a function in C."""

from collections.abc import Collection, Iterable, Mapping, Sequence

import numpy as np
import torch

from aicon_torch.export.codegen.arrays import Array
from aicon_torch.export.codegen.functions import FUNCTIONS
from aicon_torch.export.codegen.networks import NETWORK_ROUTINES
from aicon_torch.export.codegen.scalars import (
    CONSTANT,
    INPUT,
    ITEM,
    LOOP,
    OPERATIONS,
    PICK,
    Number,
    Program,
)
from aicon_torch.export.codegen.solving import ROUTINES as SOLVING_ROUTINES
from aicon_torch.export.codegen.splitting import numbers_behind, roots_of, split_by

ROUTINES = {**SOLVING_ROUTINES, **NETWORK_ROUTINES}
"""The routines that a program calls, in C."""

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
            *_tables(program),
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
    members, keep, recall = zip(*map(_kept, split.kept), strict=True) if split.kept else ((),) * 3

    fixed = [input for input in inputs if input not in varying]
    kept = f"struct {name}_kept *restrict kept"
    return "\n".join(
        [
            *_tables(program),
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


def _kept(number: Number) -> tuple[str, str, str]:
    """How a number, or an array, is declared where it is kept, kept there, and read again."""
    name, kind = f"v{number.index}", TYPES[number.kind]
    if _is_array(number):
        copied = f"  memcpy(kept->{name}, {name}, sizeof {name});"
        return (
            f"real {name}[{number.value[-1]}];",
            copied,
            f"  const real *{name} = kept->{name};",
        )
    recalled = f"  const {kind} {name} = kept->{name};"
    return f"{kind} {name};", f"  kept->{name} = {name};", recalled


def _is_array(number: Number) -> bool:
    """Whether it is all that a routine or a loop gives, and not one of that."""
    return number.operation == LOOP or number.operation in ROUTINES


def _tables(program: Program) -> list[str]:
    """The tables of constants, each once in a file."""
    lines: list[str] = []
    for name, values in program.tables.items():
        numbers = ", ".join(repr(value) + _suffix(program) for value in values)
        lines += [f"#ifndef {name.upper()}", f"#define {name.upper()}"]
        lines += [f"static const real {name}[] = {{{numbers}}};", "#endif"]
    return lines


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
    if number.operation == LOOP:
        return _loop(number, name, arguments, program)
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


def _loop(number: Number, name: str, arguments: Sequence[str], program: Program) -> list[str]:
    """An operation on each number of arrays."""
    operation, places, count = number.value
    given = iter(arguments)
    at_place = [place.format(next(given)) if "{}" in place else place for place in places]
    text = OPERATIONS[operation].text.format(*at_place, f=_suffix(program))
    return [f"  real {name}[{count}];", f"  for (int i = 0; i < {count}; ++i) {name}[i] = {text};"]


def _call(number: Number, name: str, arguments: Sequence[str]) -> list[str]:
    """The call of a routine, whose arguments and results are arrays."""
    *sizes, count = number.value
    given = f"  const real {name}_in[] = {{{', '.join(arguments)}}};"
    result = f"  real {name}[{count}];"

    pointers = f"{name}_in"
    if len(number.arguments) == 1 and _is_array(number.arguments[0]):
        given, pointers = "", arguments[0]
    if number.operation.startswith("substitute"):
        size = sizes[0]
        pointers = f"{name}_in, {name}_in + {size * size}, {name}_in + {size * size + size}"
    numbers = ", ".join(str(size) for size in sizes)
    return [*filter(None, (given, result)), f"  {number.operation}({numbers}, {pointers}, {name});"]


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
