"""What a log tells of the learned numbers, before anybody trains: their Fisher information."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import torch
from torch import Tensor, nn

from aicon_torch.errors import GraphError
from aicon_torch.graph.filtering import Filtered

NAMED = 0.3
"""Share of the largest component of a direction from which on a number is named with it."""


@dataclass(frozen=True)
class Information:
    """The Fisher information of n numbers in the readings of a log.

    Each reading's innovation is ν ~ N(0, S), both of which depend on the parameters θ. Over all of
    them (Slepian and Bangs; Mehra 1974 for innovations)

    Iᵢⱼ = Σ ∂ᵢνᵀ S⁻¹ ∂ⱼν + ½ tr(S⁻¹ ∂ᵢS S⁻¹ ∂ⱼS),

    and no unbiased estimate has a smaller covariance than I⁻¹ (Cramér and Rao). Parameters have no
    unit: see :class:`aicon_torch.learned.Learned`. Of a number that is positive, 0.1 is ten per
    cent; of another, a tenth of where it starts.

    Attributes:
        names: Of the numbers; one of several components has them in brackets.
        matrix: I, ``(n, n)``.
    """

    names: tuple[str, ...]
    matrix: Tensor

    def deviations(self) -> dict[str, float]:
        """Least standard deviation √(I⁻¹)ᵢᵢ of each number; infinite where it is not determined."""
        values, directions = torch.linalg.eigh(self.matrix)
        known = values > 1e-12 * values[-1].clamp(min=1e-12)  # less is rounding

        # (I⁻¹)ᵢᵢ = Σ vᵢ²/λ over the eigenvectors: infinite where an open direction takes part in i.
        variance = torch.where(known, 1 / values, torch.inf)
        shares = directions.square().where(directions.square() > 1e-9, 0.0)
        least = torch.where(shares > 0, shares * variance, 0.0).sum(-1).sqrt()
        return dict(zip(self.names, least.tolist(), strict=True))

    def undetermined(self, most: float = 1.0) -> list[dict[str, float]]:
        """The directions that the log leaves open: what can change together and nobody sees it.

        Args:
            most: Largest standard deviation of a direction of length one that is determined.

        Returns:
            For each the numbers that take part, and by how much.
        """
        values, directions = torch.linalg.eigh(self.matrix)
        found: list[dict[str, float]] = []

        # Along a direction of length one the variance is 1/λ.
        for direction in directions.mT[values * most**2 < 1]:
            # In shares of the number that changes most.
            direction = direction / direction[direction.abs().argmax()]
            parts = zip(self.names, direction.tolist(), strict=True)
            found.append({name: part for name, part in parts if abs(part) >= NAMED})
        return found

    def check(self, most: float = 1.0) -> None:
        """Check that the log determines every number: what it does not, no training finds.

        Args:
            most: As for :meth:`undetermined`.

        Raises:
            GraphError: If there is a direction that it leaves open; the message names it.
        """
        found = [_told(direction) for direction in self.undetermined(most)]
        if found:
            raise GraphError(
                f"The log does not determine {'; nor '.join(found)}. Leave one out, or log what "
                "it has an effect on."
            )


def information(filtered: Filtered, parameters: Mapping[str, nn.Parameter]) -> Information:
    """The information of parameters by name in what a log was filtered to.

    Raises:
        GraphError: If there are none.
    """
    if not parameters:
        raise GraphError("information: nothing learns here; ask learner = policy.learn(...).")
    outputs: list[Tensor] = []
    for innovations in filtered.innovations.values():
        outputs += [innovations.residual, innovations.spread]

    # A row for each number: its slopes, in units of the noise. I has the rows' products.
    columns = _slopes(outputs, list(parameters.values()))
    slopes = torch.stack([_whitened(filtered, column) for column in columns])
    names = [n for name, value in parameters.items() for n in _components(name, value)]
    return Information(tuple(names), slopes @ slopes.mT)


def _slopes(outputs: list[Tensor], parameters: list[nn.Parameter]) -> Iterator[list[Tensor]]:
    """∂ outputs / ∂θᵢ for each component i, one after the other.

    The gradient Jᵀv is linear in v, so that its derivative by v is a column of J.
    """
    # Jᵀv as a function of v, ...
    seeds = [torch.zeros_like(output, requires_grad=True) for output in outputs]
    total = torch.stack([(v * out).sum() for v, out in zip(seeds, outputs, strict=True)]).sum()
    pulled = torch.autograd.grad(total, parameters, create_graph=True, allow_unused=True)
    for gradient, parameter in zip(pulled, parameters, strict=True):
        for component in range(parameter.numel()):
            if gradient is None:  # what has an effect on actions only
                yield [torch.zeros_like(output) for output in outputs]
                continue

            # ... whose component i has column i of J, transposed, for its derivative.
            one = gradient.flatten()[component]
            yield list(torch.autograd.grad(one, seeds, retain_graph=True, materialize_grads=True))


@torch.no_grad()
def _whitened(filtered: Filtered, slopes: list[Tensor]) -> Tensor:
    """L⁻¹ ∂ν and L⁻¹ ∂S L⁻ᵀ / √2 of every reading that counts, with S = L Lᵀ, in one row."""
    found: list[Tensor] = []
    pairs = zip(slopes[::2], slopes[1::2], strict=True)
    for innovations, (residual, spread) in zip(filtered.innovations.values(), pairs, strict=True):
        counts = innovations.counts
        factor = torch.linalg.cholesky(innovations.spread[counts])
        off, around = residual[counts].unsqueeze(-1), spread[counts]

        # From the left, and, as ∂S is symmetric, by its transpose from the right.
        half = torch.linalg.solve_triangular(factor, around, upper=False)
        found.append(torch.linalg.solve_triangular(factor, off, upper=False).flatten())
        whole = torch.linalg.solve_triangular(factor, half.mT, upper=False)
        found.append(whole.flatten() / math.sqrt(2))
    return torch.cat(found)


def _components(name: str, value: Tensor) -> list[str]:
    """The name of a number, or of each of its components."""
    count = value.numel()
    return [name] if count == 1 else [f"{name}[{component}]" for component in range(count)]


def _told(direction: Mapping[str, float]) -> str:
    """A direction in words: a number, or how several can change together."""
    if len(direction) == 1:
        return repr(next(iter(direction)))
    return " with ".join(f"{part:+.2g} of {name!r}" for name, part in direction.items())
