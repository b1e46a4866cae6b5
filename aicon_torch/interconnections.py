"""Interconnections: differentiable relations between quantities, wired by the parameter names of a function."""

import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import Any, cast

import torch
from torch import Tensor, nn

from aicon_torch.errors import GraphError, choices

Values = Mapping[str, Tensor | float]
"""Named values of one step: quantities of shape ``(*B, *shape)`` and constants such as ``dt``."""


def wiring(function: Callable[..., object]) -> tuple[str, ...]:
    """The names of the quantities that a function (or a module's ``forward``) reads: its parameter names.

    Raises:
        GraphError: If a parameter is variadic, so that it names no quantity.
    """
    parameters = inspect.signature(function.forward if isinstance(function, nn.Module) else function).parameters
    for parameter in parameters.values():
        if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            raise GraphError(f"{function!r}: '*{parameter.name}' names no quantity; name each parameter after one.")
    return tuple(name for name, p in parameters.items() if p.default is p.empty)


class Node(nn.Module):
    """A module that is called without the hooks of :class:`torch.nn.Module`: one control step makes dozens of calls."""

    def __call__(self, *inputs: Any) -> Any:
        """What ``forward`` returns."""
        return self.forward(*inputs)


class Interconnection(Node):
    """A relation between quantities, called with all values of a step and reading those it is wired to.

    It is *explicit* where it returns a quantity (``def move(a, dt): return a * dt``) and *implicit* where it returns
    a residual that is zero when the quantities agree (``def bearing(p, z): return wrap(angle(p) - z)``).

    Args:
        function: A function or module over tensors ``(*B, …)``; leading dimensions must be free.
        inputs: Names of what it reads, one a parameter, where they differ from the parameters' names.
        **jacobians: For a quantity that the function reads, a function that returns ∂function/∂quantity
            ``(*B, m, n)``. Without one, autograd differentiates; with one, a step is faster. A world model checks them
            against autograd when it is built.
    """

    def __init__(
        self, function: Callable[..., Tensor], inputs: Sequence[str] | None = None, **jacobians: Callable[..., Tensor]
    ) -> None:
        super().__init__()
        self.function = function
        self.inputs = wiring(function) if inputs is None else tuple(inputs)
        for name in jacobians:
            if name not in self.inputs:
                raise GraphError(f"Jacobian by {name!r}: the function reads {choices(self.inputs)}.")
        self.jacobians = nn.ModuleDict({name: Interconnection(jacobian) for name, jacobian in jacobians.items()})

    @classmethod
    def of(cls, function: "Callable[..., Tensor] | Interconnection") -> "Interconnection":
        """The function as an interconnection; one that is one stays what it is."""
        return function if isinstance(function, Interconnection) else cls(function)

    def forward(self, values: Values) -> Tensor:
        """Evaluate the relation on the values that it reads."""
        return self.function(*[values[name] for name in self.inputs])

    def linearize(self, values: Values, name: str, rows: int, differentiable: bool = False) -> tuple[Tensor, Tensor]:
        """Value and Jacobian with respect to one quantity.

        Args:
            values: Named values of the step.
            name: The quantity to differentiate by, of shape ``(*B, n)``.
            rows: Number m of components of the relation's value.
            differentiable: Whether the Jacobian must itself be differentiable.

        Returns:
            The value ``(*B, m)`` and the Jacobian ``(*B, m, n)``.
        """
        if name in self.jacobians:
            return self(values), self.slope(values, name, rows, differentiable)
        if name not in self.inputs:
            value = self(values)
            return value, value.new_zeros(*value.shape, cast(Tensor, values[name]).shape[-1])
        return self.differentiate(values, name, rows, differentiable)

    def slope(self, values: Values, name: str, rows: int, differentiable: bool = False) -> Tensor:
        """The Jacobian of :meth:`linearize` alone, ``(*B, m, n)``, where the value is of no use."""
        if name in self.jacobians:
            return cast(Tensor, self.jacobians[name](values))
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
            tolerance = 100 * torch.finfo(expected.dtype).eps ** 0.5
            same_shape = given.shape[-2:] == expected.shape[-2:]
            if not (same_shape and torch.allclose(given.expand_as(expected), expected, rtol=tolerance, atol=tolerance)):
                first = [matrix.reshape(-1, *matrix.shape[-2:])[0].tolist() for matrix in (given, expected)]
                raise GraphError(
                    f"The Jacobian of {self.function!r} by {name!r} is not its derivative: at the probe it gives "
                    f"{first[0]}, autograd {first[1]}."
                )

    def differentiate(self, values: Values, name: str, rows: int, differentiable: bool) -> tuple[Tensor, Tensor]:
        """:meth:`linearize` by autograd, all rows in one backward pass.

        The inputs are repeated along a new leading dimension, and copy i is differentiated for component i.
        """
        with torch.enable_grad():
            point = cast(Tensor, values[name])
            if not (differentiable and point.requires_grad):
                point = point.detach().requires_grad_()  # a leaf of its own: only its Jacobian is asked for
            inputs = {key: values[key] for key in self.inputs} | {name: point}
            if rows == 1:
                value = self(inputs)
                (row,) = torch.autograd.grad(value, point, torch.ones_like(value), create_graph=differentiable)
                return value if differentiable else value.detach(), row.unsqueeze(-2)
            variable = point.expand(rows, *point.shape)
            copies = {key: x.expand(rows, *x.shape) if isinstance(x, Tensor) else x for key, x in inputs.items()}
            value = self(copies | {name: variable})
            selector = torch.eye(rows, dtype=value.dtype, device=value.device)
            selector = selector.reshape(rows, *(1,) * (value.dim() - 2), rows).expand_as(value)
            (jacobian,) = torch.autograd.grad(value, variable, selector, create_graph=differentiable)
            value = value[0] if differentiable else value[0].detach()  # of no further use but as a number
            return value, jacobian.movedim(0, -2)


class Affine(Interconnection):
    """``Σ_k M_k x_k``: a linear relation, whose Jacobians are constants.

    Args:
        matrices: For each quantity its matrix ``(m, n)``, or a number that stands for a multiple of the identity.

    Example:
        >>> approach = Affine(p_tar=1.0, x_rob=-1.0)  # the target comes nearer by what the robot moves
    """

    def __init__(self, **matrices: float | Tensor) -> None:
        nn.Module.__init__(self)  # there is no function to wire
        self.inputs = tuple(matrices)
        self.jacobians = nn.ModuleDict()
        self.factors = {name: value for name, value in matrices.items() if not isinstance(value, Tensor)}
        for name, value in matrices.items():
            if isinstance(value, Tensor):
                self.register_buffer(f"matrix_{name}", value.to(torch.float64))

    def _matrix(self, name: str, like: Tensor) -> Tensor:
        if name in self.factors:
            return self.factors[name] * torch.eye(like.shape[-1], dtype=like.dtype, device=like.device)
        return cast(Tensor, getattr(self, f"matrix_{name}"))

    def forward(self, values: Values) -> Tensor:
        """The sum ``(*B, m)``."""
        total: Tensor | None = None
        for name in self.inputs:
            value = cast(Tensor, values[name])
            if name in self.factors:
                factor = self.factors[name]
                term = value if factor == 1 else -value if factor == -1 else factor * value
            else:
                term = (self._matrix(name, value) * value.unsqueeze(-2)).sum(-1)
            total = term if total is None else total + term
        assert total is not None
        return total

    def linearize(self, values: Values, name: str, rows: int, differentiable: bool = False) -> tuple[Tensor, Tensor]:
        """Value ``(*B, m)`` and the constant Jacobian, ``(m, n)``; nothing is differentiated."""
        point = cast(Tensor, values[name])
        value = self(values)
        if name not in self.inputs:
            return value, point.new_zeros(rows, point.shape[-1])
        return value, self._matrix(name, point)
