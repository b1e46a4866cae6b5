"""Interconnections: differentiable relations of quantities, wired by parameter names."""

import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import torch
from torch import Tensor, nn

from aicon_torch.differentiation import hop_from, learns, pull
from aicon_torch.errors import GraphError, choices, in_order
from aicon_torch.quantities import as_number

Values = Mapping[str, Tensor]
"""Named values of one step: quantities of shape ``(*B, *shape)``, and the time step ``dt``, s.

``dt`` is a scalar, or ``(*B, 1)`` where a clock tells how long the last step took.
"""


ONE_BATCH = (
    *(nn.modules.conv._ConvNd, nn.modules.batchnorm._NormBase, nn.GroupNorm),
    *(nn.modules.pooling._MaxPoolNd, nn.modules.pooling._AvgPoolNd),
    *(nn.modules.pooling._AdaptiveMaxPoolNd, nn.modules.pooling._AdaptiveAvgPoolNd),
)
"""Layers of networks that take one batch dimension, where a graph has any number of them."""

ASKS_FOR_A_VALUE = "_local_scalar_dense"
"""What torch calls ``if``, ``float`` and ``item`` of a tensor in what it tells while it traces."""


def wiring(function: Callable[..., object]) -> tuple[str, ...]:
    """The quantities that a function (or a module's ``forward``) reads: its parameters.

    Raises:
        GraphError: If a parameter names no quantity, or cannot be given by its place.
    """
    called = function.forward if isinstance(function, nn.Module) else function
    try:
        parameters = inspect.signature(called).parameters
    except ValueError:  # functions of torch itself do not say what they take
        raise GraphError(
            f"{function!r} does not say what it takes: expected Interconnection(function, "
            "inputs=[...])."
        ) from None

    names: list[str] = []
    for name, parameter in parameters.items():
        if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            raise GraphError(
                f"{function!r}: '*{name}' names no quantity; name each parameter after one."
            )

        # What has a default is an option of the function, and no quantity.
        if parameter.default is parameter.empty:
            if parameter.kind is parameter.KEYWORD_ONLY:
                raise GraphError(
                    f"{function!r}: {name!r} may be given by name only; leave out '*'."
                )
            names.append(name)
    return tuple(names)


def wired_by(function: Callable[..., object], inputs: Sequence[str]) -> tuple[str, ...]:
    """The quantities that a function reads, by the names that were given, one a parameter.

    Raises:
        GraphError: If it cannot be given so many by their place.
    """
    names = in_order("inputs", inputs)
    called = function.forward if isinstance(function, nn.Module) else function
    try:
        inspect.signature(called).bind(*names)
    except TypeError as error:
        raise GraphError(
            f"{function!r}, inputs={list(names)}: expected one name for each parameter that can be "
            f"given by its place; {error}."
        ) from None
    except ValueError:  # as above
        pass
    return names


class Node(nn.Module):
    """A module called without the hooks of :class:`torch.nn.Module`, dozens of times a step."""

    def __call__(self, *inputs: Any) -> Any:
        """What ``forward`` returns."""
        return self.forward(*inputs)


class Interconnection(Node):
    """A relation between quantities, called with all values of a step and reading those it names.

    It is *explicit* where it returns a quantity (``def move(a, dt): return a * dt``) and *implicit*
    where it returns a residual that is zero when the quantities agree
    (``def bearing(p, z): return wrap(angle(p) - z)``).

    Args:
        function: A function or module over tensors ``(*B, …)``; leading dimensions must be free. A
            module with layers that take one batch dimension, such as convolutions and BatchNorm,
            is given one, whatever the leading dimensions are.
        inputs: Names of what it reads, one a parameter, where they differ from the parameters'
            names.
        **jacobians: For a quantity that the function reads, a function that returns
            ∂function/∂quantity ``(*B, m, n)``. Without one, autograd differentiates; with one, a
            step is faster. A world model checks them against autograd when it is built.
    """

    called = "Interconnection"

    def __init__(
        self,
        function: Callable[..., Any],
        inputs: Sequence[str] | None = None,
        **jacobians: Callable[..., Any],
    ) -> None:
        super().__init__()
        _check_callable(function, "Interconnection")
        self.function: Any = function  # a cost may have methods besides
        self.inputs = wiring(function) if inputs is None else wired_by(function, inputs)

        # A network with such layers gets its rows as one batch.
        layers = function.modules() if isinstance(function, nn.Module) else ()
        self._takes_one_batch = any(isinstance(layer, ONE_BATCH) for layer in layers)

        self.jacobians = nn.ModuleDict()
        for name, jacobian in jacobians.items():
            if name not in self.inputs:
                raise GraphError(
                    f"Jacobian by {name!r}: the function reads {choices(self.inputs)}."
                )
            self.jacobians[name] = Interconnection.of(jacobian, f"Jacobian by {name!r}")

    @classmethod
    def of(cls, function: Callable[..., Any], called: str = "Interconnection") -> "Interconnection":
        """The function as an interconnection; one that is one stays what it is.

        Args:
            function: The function.
            called: What an error calls it.

        Raises:
            GraphError: If it is no function.
        """
        _check_callable(function, called)
        if isinstance(function, Interconnection):
            return function
        relation = cls(function)
        relation.called = called
        return relation

    def forward(self, values: Values) -> Tensor:
        """Evaluate the relation on the values that it reads.

        Raises:
            GraphError: If it branches on a value while it is compiled.
        """
        inputs = [values[name] for name in self.inputs]
        try:
            if self._takes_one_batch:
                batched: Tensor = _in_one_batch(self.function, inputs)
                return batched
            value: Tensor = self.function(*inputs)
        except RuntimeError as error:
            if ASKS_FOR_A_VALUE not in str(error):
                raise
            raise GraphError(
                f"{self.called}: {self.function!r} branches on the value of a tensor, which a "
                "compiled step cannot; expected torch.where(condition, value, other)."
            ) from error
        return value

    def components(self, values: Values, called: str) -> int:
        """How many components its value has.

        Args:
            values: Named values of a step.
            called: What an error calls the relation.

        Raises:
            GraphError: If those of its terms differ.
        """
        value: Tensor = self(values)
        return value.shape[-1]

    def linearize(
        self, values: Values, name: str, rows: int, differentiable: bool = False
    ) -> tuple[Tensor, Tensor]:
        """Value and Jacobian with respect to one quantity.

        Args:
            values: Named values of the step.
            name: The quantity to differentiate by, of shape ``(*B, n)``.
            rows: Number m of components of the relation's value.
            differentiable: Whether the Jacobian must itself be differentiable.

        Returns:
            The value ``(*B, m)`` and the Jacobian ``(*B, m, n)``.
        """
        # In closed form if it was given, zero by what is not read, else by autograd.
        if name in self.jacobians:
            return self(values), self.jacobian(values, name, rows, differentiable)
        if name not in self.inputs:
            value = self(values)
            return value, value.new_zeros(*value.shape, values[name].shape[-1])
        return self.differentiate(values, name, rows, differentiable)

    def jacobian(
        self, values: Values, name: str, rows: int, differentiable: bool = False
    ) -> Tensor:
        """The Jacobian of :meth:`linearize` alone, ``(*B, m, n)``, where the value is of no use."""
        if name in self.jacobians:
            jacobian: Tensor = self.jacobians[name](values)
            return jacobian
        return self.linearize(values, name, rows, differentiable)[1]

    def verify(self, values: Values, rows: int) -> None:
        """Compare the Jacobians that were given with autograd's.

        Args:
            values: A point at which to compare.
            rows: Number of components of the relation's value.

        Raises:
            GraphError: If one differs.
        """
        for name, jacobian in self.jacobians.items():
            given = jacobian(values)
            _, expected = self.differentiate(values, name, rows, differentiable=False)
            if not _agree(given, expected):
                raise GraphError(
                    f"The Jacobian of {self.function!r} by {name!r} is not its derivative: at the "
                    f"probe it gives {_first_matrix(given)}, autograd {_first_matrix(expected)}."
                )

    def differentiate(
        self, values: Values, name: str, rows: int, differentiable: bool
    ) -> tuple[Tensor, Tensor]:
        """:meth:`linearize` by autograd, all rows in one backward pass."""
        differentiable = differentiable or learns()
        with torch.enable_grad():
            # A leaf of its own, unless the Jacobian must lead on to what the point depends on.
            point = values[name]
            if learns() or not (differentiable and point.requires_grad):
                point = hop_from(point).requires_grad_()
            inputs = {key: values[key] for key in self.inputs} | {name: point}

            if rows == 1:
                value, jacobian = self._one_row(inputs, point, differentiable)
            else:
                value, jacobian = self._several_rows(inputs, name, rows, differentiable)

        if not differentiable:
            value = value.detach()  # of no further use but as a number
        return value, jacobian

    def _one_row(
        self, inputs: Values, point: Tensor, differentiable: bool
    ) -> tuple[Tensor, Tensor]:
        """Value ``(*B, 1)`` and Jacobian ``(*B, 1, n)``: a gradient."""
        value = self(inputs)
        seed = torch.ones_like(value)
        (row,) = pull(value, point, seed, create_graph=differentiable)
        return value, row.unsqueeze(-2)

    def _several_rows(
        self, inputs: Values, name: str, rows: int, differentiable: bool
    ) -> tuple[Tensor, Tensor]:
        """Value ``(*B, m)`` and Jacobian ``(*B, m, n)``.

        The inputs are repeated along a new leading dimension, and copy i is differentiated for
        component i.
        """
        # One copy of every input for each component of the value.
        copies = copied(inputs, rows)
        outputs = self(copies)

        # Copy i of the output is asked for its component i.
        selector = torch.eye(rows, dtype=outputs.dtype, device=outputs.device)
        batch = (1,) * (outputs.dim() - 2)
        selector = selector.reshape(rows, *batch, rows).expand_as(outputs)
        (jacobian,) = pull(outputs, copies[name], selector, create_graph=differentiable)
        return outputs[0], jacobian.movedim(0, -2)


class Affine(Interconnection):
    """``Σ_k M_k x_k``: a linear relation, whose Jacobians depend on no ``x_k``.

    Args:
        matrices: For each quantity its matrix ``(m, n)``, or a number that stands for a multiple of
            the identity, or ``"dt"`` if that number is the time step.

    Example:
        >>> approach = Affine(p_tar=1.0, x_rob=-1.0)  # it comes nearer by what the robot moves
        >>> motion = Affine(x_joints=1.0, a="dt")  # joints at the velocity a
    """

    def __init__(self, **matrices: float | str | Tensor) -> None:
        nn.Module.__init__(self)  # there is no function to wire
        self.jacobians = nn.ModuleDict()

        if not matrices:
            raise GraphError("Affine(): expected a matrix for a quantity, such as Affine(x=1.0).")

        # Matrices are buffers; numbers, and names of numbers, are multiples of the identity.
        self.factors: dict[str, float | str] = {}
        for name, value in matrices.items():
            if isinstance(value, Tensor):
                self.register_buffer(f"matrix_{name}", value.to(torch.float64))
            else:
                self.factors[name] = value if isinstance(value, str) else _factor(name, value)
        named = [factor for factor in self.factors.values() if isinstance(factor, str)]
        self.inputs = (*matrices, *dict.fromkeys(named))
        self._quantities = tuple(matrices)

    def forward(self, values: Values) -> Tensor:
        """The sum ``(*B, m)``."""
        terms = [self._term(name, values) for name in self._quantities]
        total = terms[0]
        for term in terms[1:]:
            total = total + term
        return total

    def linearize(
        self, values: Values, name: str, rows: int, differentiable: bool = False
    ) -> tuple[Tensor, Tensor]:
        """Value ``(*B, m)`` and the Jacobian, ``(m, n)``; nothing is differentiated."""
        value = self(values)
        if name not in self._quantities:
            return value, value.new_zeros(rows, values[name].shape[-1])
        return value, self._matrix(name, values)

    def components(self, values: Values, called: str) -> int:
        """How many components each of its terms has: see :meth:`Interconnection.components`."""
        counts: dict[str, int] = {}
        for name in self._quantities:
            count = counts[name] = values[name].shape[-1]

            # A matrix takes as many as it has columns, and gives as many as it has rows.
            if name not in self.factors:
                shape = tuple(self._matrix(name, values).shape)
                if len(shape) != 2 or shape[1] != count:
                    raise GraphError(
                        f"{called}: the matrix of {name!r} has shape {shape}; expected "
                        f"(m, {count}), as {name!r} has {count} components."
                    )
                counts[name] = shape[0]

        # Added up as they are, one component would be added to all of another term.
        first, *others = counts
        for other in others:
            if counts[other] != counts[first]:
                raise GraphError(
                    f"{called}: the term of {first!r} has {counts[first]} components, that of "
                    f"{other!r} {counts[other]}: expected as many. A number is a multiple of the "
                    "identity; between sizes that differ stands a matrix."
                )
        return counts[first]

    def _term(self, name: str, values: Values) -> Tensor:
        """M x, ``(*B, m)``."""
        value = values[name]
        if name not in self.factors:
            return (self._matrix(name, values) * value.unsqueeze(-2)).sum(-1)

        # Multiples of the identity need no matrix, and the most common ones no product.
        factor = self.factors[name]
        if isinstance(factor, str):
            return values[factor] * value
        if factor == 1:
            return value
        if factor == -1:
            return -value
        return factor * value

    def _matrix(self, name: str, values: Values) -> Tensor:
        """M, ``(m, n)``, or ``(*B, m, n)`` if it is a multiple that differs from row to row."""
        if name not in self.factors:
            matrix: Tensor = getattr(self, f"matrix_{name}")
            return matrix

        # c I, or dt I: with a clock dt is (*B, 1), and the matrix (*B, n, n).
        like = values[name]
        identity = torch.eye(like.shape[-1], dtype=like.dtype, device=like.device)
        factor = self.factors[name]
        return (values[factor].unsqueeze(-1) if isinstance(factor, str) else factor) * identity


class Constant(Interconnection):
    """A matrix that no value changes: the Jacobian of a relation that is linear in a quantity.

    Args:
        matrix: ``(m, n)``.

    Example:
        >>> Interconnection(residual_of_a_pose, x_pose=Constant(torch.eye(3)))
    """

    matrix: Tensor

    def __init__(self, matrix: Tensor) -> None:
        nn.Module.__init__(self)  # there is no function to wire
        self.jacobians = nn.ModuleDict()
        self.inputs = ()
        self.register_buffer("matrix", matrix.to(torch.float64))

    def forward(self, values: Values) -> Tensor:
        """The matrix ``(m, n)``."""
        return self.matrix


def copied(values: Values, *count: int) -> dict[str, Tensor]:
    """The values, copied along new leading dimensions; a scalar such as ``dt`` is one for all."""
    copies: dict[str, Tensor] = {}
    for name, value in values.items():
        copies[name] = value.expand(*count, *value.shape) if value.dim() else value
    return copies


def _factor(name: str, given: Any) -> float:
    """A number that stands for a multiple of the identity."""
    factor = as_number(given)
    if not math.isfinite(factor):
        raise GraphError(
            f"Affine({name}={given!r}): expected a finite number, a matrix as a tensor, or 'dt'."
        )
    return factor


def _check_callable(function: object, called: str) -> None:
    """Check that there is a function."""
    if not callable(function):
        raise GraphError(f"{called}: expected a function of quantities, got {function!r}.")


def _in_one_batch(function: Callable[..., Any], inputs: Sequence[Tensor]) -> Any:
    """What a function returns that takes one batch dimension; it reads a vector at least.

    Vectors ``(*B, n)`` are given to it as ``(N, n)``, and matrices ``(*B, n, m)`` as ``(N, n, m)``;
    a scalar such as ``dt`` stays one.
    """
    batched = [value for value in inputs if value.dim()]

    # What the value of fewest dimensions has besides its components is the batch of all.
    leading = min(value.dim() for value in batched) - 1
    shapes = [value.shape[:leading] for value in batched]
    batch = torch.broadcast_shapes(*shapes)  # type: ignore[no-untyped-call]  # torch's

    flat: list[Tensor] = []
    for value in inputs:
        if value.dim():
            own = value.shape[leading:]
            value = value.expand(*batch, *own).reshape(-1, *own)
        flat.append(value)

    output = function(*flat)
    if isinstance(output, tuple):  # a prior's mean and covariance
        return tuple(torch.reshape(each, (*batch, *each.shape[1:])) for each in output)
    return torch.reshape(output, (*batch, *output.shape[1:]))


def _agree(given: Tensor, expected: Tensor) -> bool:
    """Whether a Jacobian ``(*B, m, n)`` is another but for rounding; it may lack the batch."""
    if given.shape[-2:] != expected.shape[-2:]:
        return False

    # Wide: it is to find a derivative that is wrong, not a sum in another order.
    tolerance = 100 * torch.finfo(expected.dtype).eps ** 0.5
    return torch.allclose(given.expand_as(expected), expected, rtol=tolerance, atol=tolerance)


def _first_matrix(jacobians: Tensor) -> list[Any]:
    """The Jacobian of the first row of the batch, as numbers to read."""
    first: list[Any] = jacobians.reshape(-1, *jacobians.shape[-2:])[0].tolist()
    return first
