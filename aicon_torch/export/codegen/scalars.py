"""A program of numbers: what a graph of tensors computes, element by element."""

import hashlib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray

from aicon_torch.export.codegen.grids import Grid

Kind = Literal["real", "int", "bool"]
"""What a number is: of the graph's precision, an index, or true or false."""

CONSTANT, INPUT, ITEM = "constant", "input", "item"
"""Numbers that are not computed: literals, elements of an input, results of a routine."""

LIST, PICK = "list", "pick"
"""Many numbers as an array, and the one of them at an index: its arguments are index and array."""


@dataclass(frozen=True, eq=False, slots=True)
class Number:
    """One number of a program.

    Attributes:
        index: Its place in the program; it depends on numbers before it only.
        operation: What it is: a name in :data:`OPERATIONS`, of a routine, or one of the above.
        arguments: What it is computed from.
        kind: Real, int or bool.
        value: Of a constant its value, of an input an :class:`Element`, of an item its place, of a
            loop a :class:`Loop`; of a pick from how many it is; of a list and a routine sizes, of
            which the last is its length.
    """

    index: int
    operation: str
    arguments: tuple["Number", ...]
    kind: Kind
    value: Any = None

    @property
    def length(self) -> int:
        """Of an array, how many numbers it has."""
        length: int = self.value.grid.count if self.operation == LOOP else self.value[-1]
        return length


class Element(NamedTuple):
    """What an input is.

    Attributes:
        name: Its name.
        place: Which of its numbers; None for all of them.
    """

    name: str
    place: int | None


LOOP = "loop"
"""An elementary operation on every number of arrays: itself an array, as a routine gives one."""


class Loop(NamedTuple):
    """What a loop is.

    Attributes:
        operation: The operation.
        places: What each of its arguments is at a place in C.
        grid: Its places.
    """

    operation: str
    places: tuple[str, ...]
    grid: Grid


@dataclass(frozen=True)
class Operation:
    """An elementary operation.

    Attributes:
        text: In C, with the arguments' places; ``{f}`` is the suffix of the precision's functions.
        fold: The same in numpy, for constants.
        of_integers: The text for integers, where that of real numbers would round them.
    """

    text: str
    fold: Callable[..., Any]
    of_integers: str | None = None

    def text_of(self, kind: Kind) -> str:
        """The text for numbers of a kind."""
        return self.of_integers if kind == "int" and self.of_integers else self.text


def _is_above(a: Any, b: Any) -> Any:
    """Whether a is larger than b, or the only one that is NaN."""
    return np.logical_or(a > b, np.logical_and(a != a, b == b))


OPERATIONS: dict[str, Operation] = {
    # Arithmetic.
    "add": Operation("{0} + {1}", np.add),
    "sub": Operation("{0} - {1}", np.subtract),
    "mul": Operation("{0} * {1}", np.multiply),
    "div": Operation("{0} / {1}", np.divide),
    "neg": Operation("-{0}", np.negative),
    "abs": Operation("fabs{f}({0})", np.abs, "{0} < 0 ? -{0} : {0}"),
    "maximum": Operation("larger({0}, {1})", np.maximum, "{0} > {1} ? {0} : {1}"),
    "minimum": Operation("smaller({0}, {1})", np.minimum, "{0} < {1} ? {0} : {1}"),
    "remainder": Operation("modulo({0}, {1})", np.remainder, "modulo_of_integers({0}, {1})"),
    "floor_divide": Operation(
        "quotient_below({0}, {1})", np.floor_divide, "quotient_of_integers({0}, {1})"
    ),
    "floor": Operation("rounded_down({0})", np.floor),
    "ceil": Operation("rounded_up({0})", np.ceil),
    "round": Operation("rounded({0})", np.rint),
    "trunc": Operation("whole_part({0})", np.trunc),
    "sqrt": Operation("sqrt{f}({0})", np.sqrt),
    # Functions: see aicon_torch.export.codegen.functions.
    "exp": Operation("exponential({0})", np.exp),
    "expm1": Operation("exponential_less_one({0})", np.expm1),
    "log": Operation("logarithm({0})", np.log),
    "log1p": Operation("logarithm_of_one_more({0})", np.log1p),
    "pow": Operation("power({0}, {1})", np.power),
    "sin": Operation("sine({0})", np.sin),
    "cos": Operation("cosine({0})", np.cos),
    "tan": Operation("tangent({0})", np.tan),
    "asin": Operation("arc_sine({0})", np.arcsin),
    "acos": Operation("arc_cosine({0})", np.arccos),
    "atan": Operation("arc_tangent({0})", np.arctan),
    "atan2": Operation("angle_of({0}, {1})", np.arctan2),
    "hypot": Operation("length_of({0}, {1})", np.hypot),
    "sinh": Operation("hyperbolic_sine({0})", np.sinh),
    "cosh": Operation("hyperbolic_cosine({0})", np.cosh),
    "tanh": Operation("hyperbolic_tangent({0})", np.tanh),
    "erf": Operation("error_function({0})", lambda x: torch.erf(torch.tensor(x)).numpy()),
    # Comparisons and choices.
    "eq": Operation("{0} == {1}", np.equal),
    "ne": Operation("{0} != {1}", np.not_equal),
    "lt": Operation("{0} < {1}", np.less),
    "le": Operation("{0} <= {1}", np.less_equal),
    "gt": Operation("{0} > {1}", np.greater),
    "ge": Operation("{0} >= {1}", np.greater_equal),
    "gt_or_nan": Operation("is_above({0}, {1})", _is_above),
    "lt_or_nan": Operation("is_above(-{0}, -{1})", lambda a, b: _is_above(-a, -b)),
    "and": Operation("{0} & {1}", np.logical_and),
    "or": Operation("{0} | {1}", np.logical_or),
    "xor": Operation("{0} ^ {1}", np.logical_xor),
    "not": Operation("!{0}", np.logical_not),
    "where": Operation("{0} ? {1} : {2}", np.where),
    # From one kind to another.
    "to_real": Operation("(real){0}", lambda x: x),
    "to_int": Operation("(integer){0}", np.trunc),
    "to_bool": Operation("{0} != 0", lambda x: x != 0),
}

NEUTRAL = {"add": (0, 0), "sub": (None, 0), "mul": (1, 1), "div": (None, 1)}
"""Left and right constants that leave the other argument as it is; −0 + 0, which is 0, stays −0."""

DECISIVE = {"and": False, "or": True}
"""The truth value that decides the outcome alone; the other one leaves the other argument."""


class Program:
    """Numbers computed from inputs, each distinct one once.

    Args:
        dtype: The precision of its real numbers.
    """

    def __init__(self, dtype: torch.dtype) -> None:
        self.dtype = dtype
        self.numbers: list[Number] = []
        self.arrays: list[NDArray[Any]] = []  # of numbers, as they were computed together
        self.tables: dict[str, Sequence[float]] = {}  # constants of routines, and places in arrays
        self._places: dict[tuple[Any, ...], Number] = {}
        self._round = np.float32 if dtype == torch.float32 else np.float64

    def constant(self, value: float, kind: Kind) -> Number:
        """A literal."""
        types: dict[Kind, Callable[[Any], Any]] = {"real": self._round, "int": int, "bool": bool}
        typed = types[kind](value)
        key = typed.tobytes() if isinstance(typed, np.floating) else typed  # −0, NaN have their own
        return self._number(CONSTANT, (), kind, typed, (CONSTANT, kind, key))

    def input(self, name: str, place: int) -> Number:
        """An element of an input, which is real."""
        return self._number(INPUT, (), "real", Element(name, place))

    def array(self, source: Number | str) -> Number:
        """What gives an array; of the name of an input, all of it."""
        if isinstance(source, Number):
            return source
        return self._number(INPUT, (), "real", Element(source, None))

    def apply(self, operation: str, arguments: tuple[Number, ...], kind: Kind) -> Number:
        """The result of an elementary operation."""
        # What is known now is computed now, and what changes nothing is left out.
        if all(argument.operation == CONSTANT for argument in arguments):
            return self._fold(operation, arguments, kind)
        shorter = self._simplified(operation, arguments)
        if shorter is not None:
            return shorter
        return self._number(operation, arguments, kind)

    def call(self, routine: str, arguments: Iterable[Number], sizes: tuple[Any, ...]) -> Number:
        """A call of a routine, whose results :meth:`item` gives."""
        return self._number(routine, tuple(arguments), "real", sizes)

    def table(self, constants: Sequence[float]) -> str:
        """The name of an array of constants, all of them real or all of them integers."""
        values = np.asarray(constants)
        if values.dtype.kind != "f":  # integers, and truth values
            values = values.astype(np.int64)

        # Named after its content, so that one table serves all functions that need it.
        digest = hashlib.sha256(values.tobytes()).hexdigest()
        name = f"table_{values.dtype.kind}_{digest[:16]}"
        self.tables[name] = values.tolist()
        return name

    def item(self, call: Number, place: int) -> Number:
        """One of the results of a routine, or of a loop."""
        return self._number(ITEM, (call,), call.kind, place)

    def loop(
        self,
        operation: str,
        arguments: Sequence[Number],
        places: Sequence[str],
        kind: Kind,
        grid: Grid,
    ) -> list[Number]:
        """The results of an operation on arrays.

        Args:
            operation: The operation.
            arguments: Arrays, and numbers that are the same for all.
            places: What its arguments are at place i, or in a row or column, with ``{}`` for each
                of these in turn.
            kind: The kind of the results.
            grid: The places.
        """
        loop = Loop(operation, tuple(places), grid)
        call = self._number(LOOP, tuple(arguments), kind, loop)
        return [self.item(call, place) for place in range(grid.count)]

    def pick(
        self, index: Number, candidates: Sequence[Number], source: Number | None = None
    ) -> Number:
        """The candidate at an index, the first one where there is none there.

        Args:
            index: The index.
            candidates: The candidates.
            source: An array that begins with them, if there is one.
        """
        array = self.list(candidates) if source is None else source
        return self._number(PICK, (index, array), array.kind, len(candidates))

    def list(self, numbers: Sequence[Number]) -> Number:
        """An array of some numbers of one kind."""
        return self._number(LIST, tuple(numbers), numbers[0].kind, (len(numbers),))

    def cast(self, number: Number, kind: Kind) -> Number:
        """The number as another kind."""
        return number if number.kind == kind else self.apply(f"to_{kind}", (number,), kind)

    def _number(
        self,
        operation: str,
        arguments: tuple[Number, ...],
        kind: Kind,
        value: Any = None,
        key: tuple[Any, ...] | None = None,
    ) -> Number:
        """The number that is this, new or known."""
        if key is None:
            key = (operation, kind, value, *(argument.index for argument in arguments))

        # The same operation on the same numbers is the same number: nothing is computed twice.
        if key not in self._places:
            number = Number(len(self.numbers), operation, arguments, kind, value)
            self.numbers.append(number)
            self._places[key] = number
        return self._places[key]

    def _fold(self, operation: str, arguments: tuple[Number, ...], kind: Kind) -> Number:
        """An operation on constants, done here."""
        with np.errstate(all="ignore"):  # infinity and NaN are results like others
            value = OPERATIONS[operation].fold(*(argument.value for argument in arguments))
        return self.constant(value, kind)

    @staticmethod
    def _simplified(operation: str, arguments: tuple[Number, ...]) -> Number | None:
        """What an operation comes to that leaves one of its arguments as it is."""
        # A choice whose condition is known, or that makes no difference.
        if operation == "where":
            condition, chosen, other = arguments
            if condition.operation == CONSTANT:
                return chosen if condition.value else other
            return chosen if chosen is other else None

        # One argument decides, as false does in an `and`.
        if operation in DECISIVE:
            for known, other in (arguments, arguments[::-1]):
                if known.operation == CONSTANT:
                    return known if known.value == DECISIVE[operation] else other

        # One argument changes nothing, as 0 does in a sum.
        if operation in NEUTRAL:
            left, right = arguments
            neutral_left, neutral_right = NEUTRAL[operation]
            if _is(left, neutral_left):
                return right
            if _is(right, neutral_right):
                return left
        return None


def array_and_place(number: Number) -> tuple[Number | str, int] | None:
    """The array that a number is in, a routine, a loop or the name of an input, and where there."""
    if number.operation == ITEM:
        return number.arguments[0], number.value
    if number.operation == INPUT:
        name, place = number.value
        return name, place
    return None


def _is(number: Number, value: float | None) -> bool:
    """Whether a number is this constant."""
    return number.operation == CONSTANT and value is not None and bool(number.value == value)
