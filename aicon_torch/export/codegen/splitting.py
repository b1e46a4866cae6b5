"""A program in two: what stays the same from call to call, and what does not.

A step takes K gradients, each with the same memory and values. What depends on those alone is
computed once a step, and handed on.
"""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass

from aicon_torch.export.codegen.scalars import CONSTANT, INPUT, Number, Program


@dataclass(frozen=True)
class Split:
    """The numbers of a program, by the indices of what is computed.

    Attributes:
        once: What the kept numbers need, and they themselves.
        each_time: What the outputs need besides.
        kept: Numbers that are computed once and read each time.
    """

    once: set[int]
    each_time: set[int]
    kept: list[Number]


def split_by(program: Program, results: Sequence[Number], varying: Collection[str]) -> Split:
    """Split a program by what depends on some of its inputs.

    Args:
        program: The program.
        results: What is written into the outputs.
        varying: The names of inputs that differ from call to call.
    """
    needed = numbers_behind(program, results)
    varies = _varying_numbers(program, varying)

    # What is read each time, by what varies or as an output; an input is there anyway.
    read = {number.index for number in results}
    for number in program.numbers:
        if number.index in needed and varies[number.index]:
            read.update(argument.index for argument in number.arguments)

    # What does not vary is kept in the struct, unless each call has it anyway.
    at_hand: list[Number] = []
    kept: list[Number] = []
    for number in program.numbers:
        if number.index in read and not varies[number.index]:
            is_given = number.operation in (CONSTANT, INPUT)
            (at_hand if is_given else kept).append(number)

    each_time = {index for index in needed if varies[index]}
    each_time.update(number.index for number in at_hand)
    return Split(numbers_behind(program, kept), each_time, kept)


def numbers_behind(program: Program, roots: Iterable[Number]) -> set[int]:
    """The indices of some numbers and of all that they depend on."""
    # Arguments stand before what is computed of them, so one pass backward finds all.
    needed = {number.index for number in roots}
    for number in reversed(program.numbers):
        if number.index in needed:
            needed.update(argument.index for argument in number.arguments)
    return needed


def _varying_numbers(program: Program, varying: Collection[str]) -> list[bool]:
    """Of each number whether it depends on one of these inputs."""
    varies: list[bool] = []
    for number in program.numbers:
        if number.operation == INPUT:
            varies.append(number.value.name in varying)
        else:
            varies.append(any(varies[argument.index] for argument in number.arguments))
    return varies
