"""A program of numbers as a function in C."""

import re
from collections.abc import Collection, Iterable, Mapping, Sequence

import torch

from aicon_torch.export.codegen.arrays import Array
from aicon_torch.export.codegen.functions import FUNCTIONS
from aicon_torch.export.codegen.scalars import Number, Program
from aicon_torch.export.codegen.splitting import numbers_behind, split_by
from aicon_torch.export.codegen.statements import (
    ROUTINES,
    TYPES,
    Statements,
    is_array,
    real_literal,
    suffix_of,
)
from aicon_torch.export.codegen.writes import Write, writes_of

UNNEEDED = """\
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("no-gcse", "no-rerun-cse-after-loop", "no-cse-follow-jumps", "no-tree-pre")
#pragma GCC optimize("no-code-hoisting", "no-tree-vrp", "no-thread-jumps", "no-tree-dse", "no-dse")
#pragma GCC optimize("no-tree-fre", "vect-cost-model=dynamic", "unswitch-loops")
#endif
"""
"""What gcc need not look for: a program computes each distinct number once, and stores it once. But
it shall compute several places of a loop at a time wherever that pays, and ask once before a loop
what is the same at all of its places.

Without that search gcc 12 takes 11 instead of 19 s for a reaching UR5, whose step runs as fast.
"""


def prelude(dtype: torch.dtype) -> str:
    """What every function needs: the types, and operations that C does not have.

    Args:
        dtype: The precision of real numbers.
    """
    is_single = dtype == torch.float32
    name, suffix, rounding = ("float", "f", "1e-4f") if is_single else ("double", "", "1e-9")

    # As in torch, NaN wins: what is compared with it is neither less nor more. Both sides of & are
    # computed, so that loops have no branches, and are done for several numbers at a time.
    return f"""\
{UNNEEDED}
#include <math.h>

typedef {name} real;
typedef long long integer;

#define ROUNDING {rounding}
static inline real magnitude(real a) {{ return fabs{suffix}(a); }}
static inline real root(real a) {{ return sqrt{suffix}(a); }}
static inline int is_above(real a, real b) {{ return !(a <= b) & (b == b); }}
static inline real larger(real a, real b) {{ return is_above(a, b) ? a : b; }}
static inline real smaller(real a, real b) {{ return (!(a >= b) & (b == b)) ? a : b; }}
{FUNCTIONS}
static inline real modulo(real a, real b) {{
  real rest = rest_of(a, b);
  return (rest != 0 && (rest < 0) != (b < 0)) ? rest + b : rest;
}}
static inline real quotient_below(real a, real b) {{
  if (b == 0) return a / b;
  real rest = rest_of(a, b), quotient = (a - rest) / b;
  if (rest != 0 && (rest < 0) != (b < 0)) quotient -= 1;
  if (quotient == 0) return copysign{suffix}(0, a / b);
  real whole = rounded_down(quotient);
  return quotient - whole > (real)0.5 ? whole + 1 : whole;
}}

/* The same of integers, beyond those that are real numbers; by 0 both are 0, where torch stops. */
static inline integer modulo_of_integers(integer a, integer b) {{
  integer rest = b == 0 ? 0 : a % b;
  return (rest != 0 && (rest < 0) != (b < 0)) ? rest + b : rest;
}}
static inline integer quotient_of_integers(integer a, integer b) {{
  if (b == 0) return 0;
  return a / b - (a % b != 0 && (a < 0) != (b < 0));
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
    # From the outputs back: what none of them needs is not computed.
    writes = writes_of(program, outputs)
    results = [write.number for write in writes]
    body = Statements(program, numbers_behind(program, results), results)
    lines = [
        f"static void {name}({_parameters(inputs, outputs)}) {{",
        *body.lines(),
        *_assignments(writes, body),
        "}\n",
    ]
    return "\n".join([*_tables(program, lines), *lines])


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
    # What depends on nothing that varies is computed once, and kept in a struct.
    writes = writes_of(program, outputs)
    results = [write.number for write in writes]
    split = split_by(program, results, varying)
    once = Statements(program, split.once, split.kept)
    each_time = Statements(program, split.each_time, results)

    fixed = [input for input in inputs if input not in varying]
    kept = f"struct {name}_kept *restrict kept"
    lines = [
        f"struct {name}_kept {{ {' '.join(map(_member, split.kept))} }};",
        f"static void {name}_once({_parameters(fixed, (), kept)}) {{",
        *once.lines(),
        *(_keep(number, once) for number in split.kept),
        "}\n",
        f"static void {name}({_parameters(inputs, outputs, f'const {kept}')}) {{",
        *map(_recall, split.kept),
        *each_time.lines(),
        *_assignments(writes, each_time),
        "}\n",
    ]
    return "\n".join([*_tables(program, lines), *lines])


def _member(number: Number) -> str:
    """The declaration of where a number, or an array, is kept."""
    size = f"[{number.length}]" if is_array(number) else ""
    return f"{TYPES[number.kind]} v{number.index}{size};"


def _keep(number: Number, body: Statements) -> str:
    """What keeps it."""
    name = f"v{number.index}"
    if is_array(number):
        return f"  memcpy(kept->{name}, {name}, sizeof {name});"
    return f"  kept->{name} = {body.text(number)};"


def _recall(number: Number) -> str:
    """What reads it again."""
    pointer = "*" if is_array(number) else ""
    return f"  const {TYPES[number.kind]} {pointer}v{number.index} = kept->v{number.index};"


def _tables(program: Program, statements: Iterable[str]) -> list[str]:
    """The tables of constants that some statements read, each once in a file."""
    read = set(re.findall(r"table_\w+", "\n".join(statements)))
    lines: list[str] = []
    for name, values in program.tables.items():
        if name not in read:
            continue

        # A table is named after its content, so several functions of a file may bring the same one.
        type, texts = "int", [str(value) for value in values]
        if isinstance(values[0], float):
            type, texts = "real", [real_literal(value, suffix_of(program)) for value in values]
        lines += [f"#ifndef {name.upper()}", f"#define {name.upper()}"]
        lines += [f"static const {type} {name}[] = {{{', '.join(texts)}}};", "#endif"]
    return lines


def _parameters(inputs: Iterable[str], outputs: Iterable[str], *between: str) -> str:
    """The parameters of a function."""
    # restrict: what is written is read through no other pointer, so values may stay in registers.
    given = [f"const real *restrict {input}" for input in inputs]
    found = [f"real *restrict {output}" for output in outputs]
    return ", ".join([*given, *between, *found])


def _assignments(writes: Iterable[Write], body: Statements) -> list[str]:
    """What writes the outputs."""
    lines: list[str] = []
    for output, place, number, first, length in writes:
        text = body.text(number)
        if first is None:
            lines.append(f"  {output}[{place}] = {text};")
        else:
            size = f"{length} * sizeof(real)"
            lines.append(f"  memcpy({output} + {place}, {text} + {first}, {size});")
    return lines
