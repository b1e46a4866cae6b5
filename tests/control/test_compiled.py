"""The compiled policy takes the steps of the one it is made of, or says why it cannot."""

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
import torch
from _asserts import assert_same_steps
from _inputs import drifting, normal
from torch import Tensor

from aicon_torch import (
    EKF,
    Actuator,
    Affine,
    Deterministic,
    DirectDescent,
    Goal,
    Measurement,
    Policy,
    Sensor,
    Sum,
    WorldModel,
    make_policy,
)

Readings = list[dict[str, Tensor]]


with_compiler = pytest.mark.skipif(
    not shutil.which(os.environ.get("CXX", "g++")), reason="there is no C++ compiler"
)


def distance(p: Tensor) -> Tensor:
    return (p * p).sum(-1).sqrt()


def bold_when_far(p: Tensor) -> Tensor:
    """No function of tensors alone: it looks at a value and branches."""
    return distance(p) if float(p.detach()[..., 0].mean()) > 1.0 else 2.0 * distance(p)


def follower(cost: Callable[..., Tensor] = distance) -> Policy:
    """A point that follows what it sees now and then."""
    seen = Measurement(Affine(p=1.0, z=-1.0), noise=0.01, size=2)

    model = WorldModel(
        sensors={"z": Sensor(2, "m", optional=True)},
        actuators={"a": Actuator(2, "m/s", limit=1.0)},
        estimators=[
            Deterministic("x", lambda a, dt: a * dt, is_motion=True),
            EKF(
                "p",
                "P",
                predict=Affine(p=1.0, x=-1.0),
                noise=1e-4,
                initial=((1.0, 0.0), 1.0),
                correct=[seen],
            ),
        ],
        goals=[Goal("near", cost)],
        dt=0.1,
        dtype=torch.float64,
    )

    return Policy(model, Sum(), DirectDescent(gain=1.0))


def wandering(steps: int, batch: tuple[int, ...] = ()) -> Readings:
    """Where the point is seen; every third time it is not."""
    readings: Readings = []

    for step in range(steps):
        is_seen = batch != () or step % 3 != 2
        readings.append({"z": 2.0 + normal(*batch, 2, seed=step)} if is_seen else {})

    return readings


CORNERS = [(-60, -45), (60, -45), (60, -15), (-60, -15), (-15, -15), (15, -15), (15, 75), (-15, 75)]
"""The corners of the T in its own frame, px."""


def corners_at(pose: Tensor) -> Tensor:
    """The corners ``(*B, 16)`` of the T at (x, y, θ) ``(*B, 3)``, px and rad."""
    x, y = torch.tensor(CORNERS, dtype=torch.float64).unbind(-1)
    cos, sin = torch.cos(pose[..., 2:]), torch.sin(pose[..., 2:])

    turned = torch.stack((cos * x - sin * y, sin * x + cos * y), dim=-1)
    return (turned + pose[..., None, :2]).flatten(-2)


def passing(steps: int, batch: tuple[int, ...] = ()) -> Readings:
    """A pusher that passes by the T, whose corners are not always seen."""
    start = torch.tensor([256.0, 300.0, 0.3], dtype=torch.float64)
    spread = torch.tensor([1.0, 1.0, 0.01], dtype=torch.float64)
    readings: Readings = []

    for step in range(steps):
        pusher = torch.tensor([150.0 + 9.0 * step, 250.0 + 3.0 * step], dtype=torch.float64)
        pusher = pusher + normal(*batch, 2, seed=100 + step)

        corners = corners_at(start + spread * normal(*batch, 3, seed=step))
        if step % 4 == 3:
            corners = torch.full_like(corners, torch.nan)
        readings.append({"agent_pos": pusher, "environment_state": corners})

    return readings


@with_compiler
@pytest.mark.parametrize(
    ("policy", "readings"),
    [
        pytest.param(follower(), wandering(12), id="follower"),
        pytest.param(make_policy("nav2d"), drifting(150, (3,)), id="nav2d"),
        pytest.param(follower().to(torch.float32), wandering(12), id="in float32"),
        pytest.param(make_policy("pusht"), passing(30, (2,)), id="pusht"),
    ],
)
def test_it_takes_the_same_steps(policy: Policy, readings: Readings) -> None:
    assert_same_steps(policy, policy.compile(), readings)


@with_compiler
def test_single_precision_is_as_near_to_double_precision_as_without_compiling() -> None:
    """A step of many gradients amplifies what either rounds, so they may not be near each other."""
    exact = make_policy("nav2d")
    single = make_policy("nav2d", dtype=torch.float32)
    compiled, memory = single.compile(), None

    for reading in drifting(40):
        doubled = memory and {name: widened(value) for name, value in memory.items()}
        expected, _ = exact.predict(reading, doubled)
        found, _ = compiled.predict(reading, memory)
        action, memory = single.predict(reading, memory)
        error, own = (float((a - expected).abs().max()) for a in (found, action))
        assert error < 1e-5 + 4 * own


def widened(value: Tensor) -> Tensor:
    """Real numbers in double precision, others as they are."""
    return value.double() if value.is_floating_point() else value


@with_compiler
def test_what_has_no_translation_to_c_is_compiled_otherwise() -> None:
    """By TorchInductor, as on other devices."""
    policy = follower()
    compiled = policy.compile()
    compiled._native = None
    assert_same_steps(policy, compiled, wandering(6, (3,)))


@with_compiler
@pytest.mark.slow
def test_the_arm_takes_the_same_steps() -> None:
    """What it sees is read outside the part that is compiled."""
    panda = pytest.importorskip("aicon_envs.panda_push", reason="the arm needs MuJoCo")
    env, policy, memory, readings = panda.PandaPushEnv(), make_policy("panda_push"), None, []

    try:
        observation, _ = env.reset(seed=1000)
    except RuntimeError as error:
        pytest.skip(str(error))

    for _ in range(120):
        readings.append(observation)
        action, memory = policy.predict(observation, memory)
        observation, *_ = env.step(action)

    env.close()
    assert_same_steps(policy, policy.compile(), readings)


@with_compiler
def test_it_is_a_policy_like_any_other() -> None:
    """Other batches, numpy, episodes that begin, saved memories, other precisions, explanations."""
    policy = follower()
    compiled = policy.compile()

    assert_same_steps(policy, compiled, wandering(4, (3,)))
    assert_same_steps(policy, compiled, wandering(4))

    # Episodes that begin, and a memory that lies otherwise in storage.
    first, second = wandering(2, (3,))
    _, memory = compiled.predict(first)
    strided = dict(memory)
    for name, value in memory.items():
        if value.dim() > 1:
            strided[name] = value.clone().mT.contiguous().mT

    begins = torch.tensor([False, True, False])
    for state in (memory, strided):
        expected = policy.predict(second, memory, begins)
        found = compiled.predict(second, state, begins)
        torch.testing.assert_close(found, expected)

    action, memory = compiled.predict({"z": [3.0, 1.0]})
    assert action.dtype == "float32"
    assert str(compiled.explain(memory)) == str(policy.explain(memory))

    single = compiled.to(torch.float32)
    assert single.predict(wandering(1)[0])[1]["P"].dtype == torch.float32


def test_what_cannot_be_traced_runs_uncompiled() -> None:
    policy = follower(bold_when_far)
    compiled = policy.compile()
    with pytest.warns(RuntimeWarning, match="runs uncompiled.*branch on values") as warned:
        assert_same_steps(policy, compiled, wandering(6))
    assert len(warned) == 1


def test_without_a_compiler_it_runs_uncompiled(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("CC", "no-such-compiler")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))  # nothing was compiled before
    config = pytest.importorskip("torch._inductor.config")
    policy = follower()
    compiled = policy.compile()

    with (
        config.patch({"cpp.cxx": ("no-such-compiler",), "force_disable_caches": True}),
        pytest.warns(RuntimeWarning, match=r"runs uncompiled.*C\+\+ compiler") as warned,
    ):
        assert_same_steps(policy, compiled, wandering(6))

    assert len(warned) == 1
