"""Layers of networks, with their derivatives, compute in C what they compute in torch."""

from pathlib import Path

import pytest
import torch
from _inputs import normal
from _inputs.translated import translated
from torch import Tensor, nn

LAYERS: dict[str, nn.Module] = {
    "GELU": nn.GELU(),
    "GELU by tanh": nn.GELU("tanh"),
    "ELU": nn.ELU(alpha=0.7),
    "SELU": nn.SELU(),
    "LeakyReLU": nn.LeakyReLU(0.2),
    "ReLU6": nn.ReLU6(),
    "Hardtanh": nn.Hardtanh(-0.5, 0.8),
    "SiLU": nn.SiLU(),
    "Mish": nn.Mish(),
    "Softplus": nn.Softplus(),
    "LogSoftmax": nn.LogSoftmax(-1),
    "LayerNorm": nn.LayerNorm(12),
    "LayerNorm of two dimensions": nn.Sequential(nn.Unflatten(-1, (3, 4)), nn.LayerNorm((3, 4))),
    "BatchNorm": nn.Sequential(nn.Unflatten(-1, (1, 12)), nn.BatchNorm1d(12)),
}


def prepared(layer: nn.Module) -> nn.Module:
    """In use, with numbers that tell one parameter from another."""
    layer = layer.double().eval()
    state = layer.state_dict()
    for index, (name, value) in enumerate(state.items()):
        if value.is_floating_point():
            state[name] = 0.5 + normal(*value.shape, seed=index).abs()
    layer.load_state_dict(state)
    return layer


@pytest.mark.parametrize("name", LAYERS)
def test_a_layer_and_its_derivative_are_translated(name: str, tmp_path: Path) -> None:
    layer = prepared(LAYERS[name])

    def value_and_gradient(x: Tensor) -> Tensor:
        with torch.enable_grad():
            leaf = (3.0 * x).detach().requires_grad_()  # far enough for ReLU6 to be at its bound
            value = layer(leaf)
            (gradient,) = torch.autograd.grad(value.square().sum(), leaf)
        return torch.cat((value.detach().flatten(), gradient))

    run = translated(value_and_gradient, torch.float64, tmp_path)
    for seed in range(3):
        x = normal(12, seed=seed)
        torch.testing.assert_close(run(x), value_and_gradient(x), rtol=1e-12, atol=1e-12)


def test_a_product_of_two_tables_of_constants_is_one(tmp_path: Path) -> None:
    first, second = normal(20, 20), normal(20, 20, seed=1)

    def weighted(x: Tensor) -> Tensor:
        return (first @ second)[: len(x), 0] * x

    x = normal(12)
    torch.testing.assert_close(translated(weighted, torch.float64, tmp_path)(x), weighted(x))
