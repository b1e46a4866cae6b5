"""Forward kinematics and Jacobian of seven robots against MuJoCo's."""

import pytest
import torch
from _inputs.robots import (
    ROBOTS,
    Physics,
    mujoco_model,
    random_postures,
    read_chain,
    robot_file,
)
from torch import Tensor

pytest.importorskip("pytorch_kinematics")
mujoco = pytest.importorskip("mujoco")


@pytest.fixture(scope="module", params=ROBOTS)
def name(request: pytest.FixtureRequest) -> str:
    robot: str = request.param
    return robot


@pytest.fixture(scope="module")
def physics(name: str) -> Physics:
    model = mujoco_model(robot_file(ROBOTS[name].urdf))
    return Physics(model, read_chain(name).names)


def expected(physics: Physics, q: Tensor, tip: str) -> tuple[Tensor, Tensor]:
    """Frames and Jacobians at each posture ``(*B, n)``."""
    frames, jacobians = [], []
    for posture in q.reshape(-1, q.shape[-1]):
        physics.move(posture)
        frames.append(physics.frames(tip))
        jacobians.append(physics.jacobian(tip))

    batch = q.shape[:-1]
    return torch.stack(frames).reshape(*batch, -1, 4, 4), torch.stack(jacobians).reshape(
        *batch, 6, -1
    )


@pytest.mark.parametrize("batch", [(), (3,), (2, 3)], ids=str)
def test_frames_and_jacobian_are_those_of_the_physics(
    name: str, physics: Physics, batch: tuple[int, ...]
) -> None:
    chain, tip = read_chain(name), ROBOTS[name].tip
    q = random_postures(chain, 6)[: max(1, torch.Size(batch).numel())]
    q = q.reshape(*batch, -1)
    frames, jacobian = expected(physics, q, tip)

    for found, wanted in (
        (chain.frames(q), frames),
        (chain(q), frames[..., -1, :, :]),
        (chain.jacobian(q), jacobian),
    ):
        assert found.shape == wanted.shape and found.dtype == torch.float64
        torch.testing.assert_close(found, wanted, rtol=0, atol=1e-9)


def test_in_single_precision_too(name: str) -> None:
    chain = read_chain(name)
    q = random_postures(chain, 5)

    for function in (chain, chain.frames, chain.jacobian):
        found = function(q.float())
        assert found.dtype == torch.float32
        torch.testing.assert_close(found.double(), function(q), rtol=0, atol=1e-5)


def test_limits_are_those_of_the_physics(name: str, physics: Physics) -> None:
    chain = read_chain(name)
    for joint, low, high in zip(chain.names, chain.low, chain.high, strict=True):
        found = physics.model.joint(joint)
        if low.isfinite():
            assert found.limited
            assert found.range.tolist() == pytest.approx([float(low), float(high)], abs=1e-12)
        else:  # before MuJoCo 4 a continuous joint had the limits that its description names, too
            assert (low, high) == (-torch.inf, torch.inf)
            assert not found.limited or int(mujoco.__version__[0]) < 4


def test_every_joint_has_a_speed(name: str) -> None:
    speed = read_chain(name).speed
    assert (speed > 0).all() and speed.isfinite().all()
