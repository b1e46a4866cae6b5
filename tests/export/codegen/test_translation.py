"""What is translated to C computes what torch computes, number by number."""

from pathlib import Path

import pytest
import torch
from _inputs import normal
from _inputs.translated import Function, translated
from torch import Tensor

from aicon_torch.errors import GraphError
from aicon_torch.export.codegen import in_c
from aicon_torch.export.codegen.translation import TRANSLATIONS

SIZE = 12


def index_of(x: Tensor) -> Tensor:
    """An index, 0 to 3, that follows from the numbers."""
    return x[:4].argmax(-1, keepdim=True)


def written(x: Tensor) -> Tensor:
    """A tensor that is written to where it stands, by way of a view."""
    y = x.clone()
    y[2:4] = 7.0
    y[5].copy_(x[0])
    return y


def descended(x: Tensor, is_turned: bool = False) -> Tensor:
    """A gradient through a solution, which the step has in its filters."""
    with torch.enable_grad():
        leaf = x[:9].detach().clone().requires_grad_()
        matrix = leaf.reshape(3, 3) + 3.0 * torch.eye(3, dtype=x.dtype)
        solution = torch.linalg.solve_ex(matrix.mT if is_turned else matrix, x[9:]).result
        (gradient,) = torch.autograd.grad(solution.square().sum(), leaf)
    return gradient


FUNCTIONS: dict[str, Function] = {
    # Element by element.
    "arithmetic": lambda x: (x * 2 - x / 3 + 1).abs() - x.neg() ** 2 + x.square().sqrt(),
    "functions": lambda x: torch.exp(x) + torch.sin(x) * torch.cos(x) + torch.tanh(x) + x.erf(),
    "lengths": lambda x: torch.hypot(x, x.flip(0)),
    "angles": lambda x: torch.atan2(x, x.flip(0)) + torch.remainder(x, 2.0) + x.sigmoid(),
    "bounds": lambda x: x.clamp(-0.5, 0.5) + torch.maximum(x, x.flip(0)) + x.clamp(min=0.1),
    "logic": lambda x: torch.where((x > 0) & ~(x > 1) | (x < -1), x, -x) + (x > 0).to(x.dtype),
    "missing": lambda x: (x / (x - x)).nan_to_num(nan=3.0, posinf=2.0, neginf=1.0),
    "finite": lambda x: (x / x.relu()).isfinite().to(x.dtype),
    "powers of their own": lambda x: 2.0**x + x.abs() ** x.flip(0),
    "rounded down": lambda x: torch.div((10 * x).round() / 10, 0.1, rounding_mode="floor") + x // 1,
    "rounded down by nothing": lambda x: torch.div(x, x.relu(), rounding_mode="floor").clamp(-3, 3),
    "powers": lambda x: x.abs() ** 1.5 + x**3 + x.abs().rsqrt() + torch.sign(x),
    # Sums and the like.
    "sums": lambda x: x.reshape(3, 4).sum(-1) + x.reshape(3, 4).mean(1) + x.prod(),
    "spreads": lambda x: x.reshape(3, 4).var(-1) + x.std() + x.view(3, 4).var(1, correction=0),
    "norms": lambda x: torch.linalg.vector_norm(x.reshape(3, 4), dim=0) + x.norm(1),
    "softmax": lambda x: torch.softmax(x.reshape(3, 4), -1).flatten() + x.logsumexp(0),
    "products": lambda x: (x.reshape(3, 4) @ x.reshape(4, 3) @ x[:3]).flatten(),
    "any and all": lambda x: torch.stack([(x > 1).any(), (x > -9).all()]).to(x.dtype),
    # Comparisons.
    "largest": lambda x: torch.cat([x.amax().view(1), x.amin().view(1), *x.view(3, 4).max(1)]),
    "indices": lambda x: torch.stack([x.argmax(), x.argmin()]).to(x.dtype),
    "top": lambda x: torch.cat([*x.view(3, 4).topk(2, -1)], -1).flatten(),
    "order": lambda x: torch.cat([*x.sort(descending=True)]),
    "running": lambda x: x.cumsum(0),
    # Parts and places.
    "parts": lambda x: torch.cat([x[1::3], x.view(3, 4)[:, -1], x.view(3, 4).T.flatten()]),
    "diagonal": lambda x: torch.diag_embed(x[:3]).flatten() + x.view(3, 4)[:, :3].diagonal().sum(),
    "picked": lambda x: x.gather(0, index_of(x)) + x.view(4, 3)[index_of(x)].sum(),
    "placed": lambda x: x.scatter(0, index_of(x), 5.0) + x.scatter_add(0, index_of(x), x[:1]),
    "selected": lambda x: x.view(4, 3).index_select(0, index_of(x)).flatten() + x[[0, 2, 5]],
    "written": written,
    # Linear systems.
    "solution": lambda x: torch.linalg.solve_ex(x[:9].view(3, 3), x[9:]).result,
    "descended": descended,
    "descended through a transpose": lambda x: descended(x, is_turned=True),
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_it_computes_what_torch_computes(name: str, tmp_path: Path) -> None:
    function = FUNCTIONS[name]
    run = translated(function, torch.float64, tmp_path)
    for seed in range(3):
        x = normal(SIZE, seed=seed)
        expected = function(x).flatten().to(x.dtype)
        torch.testing.assert_close(run(x), expected, rtol=1e-12, atol=1e-12, equal_nan=True)


def test_single_precision_stays_single(tmp_path: Path) -> None:
    function = FUNCTIONS["functions"]
    x = normal(SIZE, seed=3).float()
    found = translated(function, torch.float32, tmp_path)(x)
    torch.testing.assert_close(found, function(x), rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize(
    ("function", "culprit"),
    [
        (lambda x: x.round(decimals=1), "round"),
        (lambda x: x.scatter(0, index_of(x), 2.0, reduce="add"), "scatter"),
        (
            lambda x: torch.addmm(x[:4].view(2, 2), x[4:8].view(2, 2), x[8:].view(2, 2), beta=2),
            "mm",
        ),
    ],
)
def test_an_argument_without_a_translation_is_refused(function: Function, culprit: str) -> None:
    with pytest.raises(GraphError, match=f"{culprit}.* cannot be exported"):
        in_c("f", lambda x: (function(x).flatten(),), ["x"], ["y"], {"x": normal(SIZE, seed=1)})


def test_an_error_within_a_translation_is_not_taken_for_a_missing_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def broken(writer: object, kind: object, value: object) -> None:
        raise TypeError("a slip")

    monkeypatch.setitem(TRANSLATIONS, "sin", broken)
    with pytest.raises(TypeError, match="a slip"):
        in_c("f", lambda x: (x.sin(),), ["x"], ["y"], {"x": normal(SIZE)})


def test_what_has_no_translation_is_named() -> None:
    def decomposed(x: Tensor) -> tuple[Tensor, ...]:
        return (torch.linalg.svdvals(x.view(3, 4)),)

    with pytest.raises(GraphError, match="svd.* cannot be exported"):
        in_c("f", decomposed, ["x"], ["y"], {"x": normal(SIZE)})
