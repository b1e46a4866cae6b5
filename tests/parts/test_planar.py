"""Geometry of the plane, against complex numbers and other closed forms."""

import math

import pytest
import torch
from _inputs import normal

from aicon_torch.parts import cross, norm, pose_error, rotate, wrap_angle


def as_complex(vectors: torch.Tensor) -> torch.Tensor:
    return torch.view_as_complex(vectors.contiguous())


def test_the_norm_is_euclidean_and_has_a_derivative_at_zero() -> None:
    vectors = normal(5, 3)
    torch.testing.assert_close(norm(vectors), torch.linalg.vector_norm(vectors, dim=-1))

    origin = torch.zeros(2, dtype=torch.float64, requires_grad=True)
    (slope,) = torch.autograd.grad(norm(origin), origin)
    assert slope.tolist() == [0.0, 0.0]


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64], ids=str)
def test_lengths_of_a_micrometre_are_lengths_still(dtype: torch.dtype) -> None:
    short = torch.tensor([3e-6, 4e-6], dtype=dtype)
    assert float(norm(short)) == pytest.approx(5e-6, rel=1e-5)


def test_rotation_and_cross_product_are_those_of_the_complex_plane() -> None:
    vectors, others, angle = normal(4, 7, 2), normal(4, 7, 2, seed=1), normal(4, 1, seed=2)

    turned = as_complex(vectors) * torch.exp(1j * angle)
    torch.testing.assert_close(rotate(vectors, angle), torch.view_as_real(turned))
    product = as_complex(vectors).conj() * as_complex(others)
    torch.testing.assert_close(cross(vectors, others), product.imag)


def test_angles_wrap() -> None:
    angles = torch.tensor([0.0, 3.0, 4.0, -4.0, 7.0, math.pi], dtype=torch.float64)
    expected = torch.atan2(torch.sin(angles), torch.cos(angles))

    torch.testing.assert_close(wrap_angle(angles)[:-1], expected[:-1])
    assert wrap_angle(angles)[-1] == -math.pi  # the interval is half open


def test_the_pose_error_goes_the_shorter_way_round() -> None:
    pose = torch.tensor([1.0, 2.0, 3.0], dtype=torch.float64)
    target = torch.tensor([0.5, 4.0, -3.0], dtype=torch.float64)

    error = pose_error(pose, target, rotation_length=0.1)
    expected = torch.tensor([0.5, -2.0, 0.1 * (6.0 - 2 * math.pi)], dtype=torch.float64)
    torch.testing.assert_close(error, expected)
