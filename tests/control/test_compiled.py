"""The compiled policy takes the steps of the one it is made of, or says why it cannot."""

import os
import shutil
from collections.abc import Callable

import pytest
import torch
from _inputs import drifting, normal
from torch import Tensor

from aicon_torch import (
    EKF,
    ActionLaw,
    Actuator,
    Affine,
    Deterministic,
    Goal,
    Measurement,
    Policy,
    Sensor,
    Sum,
    WorldModel,
    make_policy,
)
from aicon_torch.parts.rigid_object import Outline

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

    return Policy(model, Sum(), ActionLaw(gain=1.0))


def wandering(steps: int, batch: tuple[int, ...] = ()) -> Readings:
    """Where the point is seen; every third time it is not."""
    readings: Readings = [{"z": 2.0 + normal(*batch, 2, seed=step)} for step in range(steps)]
    return [
        {} if batch == () and step % 3 == 2 else reading for step, reading in enumerate(readings)
    ]


def passing(steps: int, batch: tuple[int, ...] = ()) -> Readings:
    """A pusher that passes by the T, whose corners are not always seen."""
    outline, readings = Outline.of(), []

    for step in range(steps):
        pose = torch.tensor([256.0, 300.0, 0.3]) + normal(*batch, 3, seed=step) * torch.tensor(
            [1.0, 1.0, 0.01]
        )
        corners = outline.placed(pose.double()).flatten(-2)
        pusher = torch.tensor([150.0 + 9.0 * step, 250.0 + 3.0 * step]) + normal(
            *batch, 2, seed=100 + step
        )
        missing = torch.full_like(corners, torch.nan)
        readings.append(
            {"agent_pos": pusher, "environment_state": missing if step % 4 == 3 else corners}
        )

    return readings


def assert_same_steps(
    policy: Policy, compiled: Policy, readings: Readings, tolerance: float
) -> None:
    """Step by step from the same memory, since errors grow along a chaotic run."""
    memory = None

    for reading in readings:
        action, expected = policy.predict(reading, memory)
        same, memory = compiled.predict(reading, memory)

        torch.testing.assert_close(same, action, rtol=tolerance, atol=tolerance)

        for name, value in expected.items():
            torch.testing.assert_close(
                memory[name],
                value,
                rtol=tolerance,
                atol=tolerance,
                msg=lambda text, name=name: f"{name}: {text}",
            )

        memory = expected


@with_compiler
@pytest.mark.parametrize(
    ("policy", "readings", "tolerance"),
    [
        pytest.param(follower(), wandering(12), 1e-12, id="follower"),
        pytest.param(make_policy("nav2d"), drifting(150, (3,)), 1e-10, id="nav2d"),
        pytest.param(
            make_policy("nav2d", dtype=torch.float32), drifting(60), 1e-5, id="nav2d in float32"
        ),
        pytest.param(make_policy("pusht"), passing(30, (2,)), 1e-10, id="pusht"),
    ],
)
def test_it_takes_the_same_steps(policy: Policy, readings: Readings, tolerance: float) -> None:
    assert_same_steps(policy, policy.compile(), readings, tolerance)


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
    assert_same_steps(policy, policy.compile(), readings, 1e-10)


@with_compiler
def test_it_is_a_policy_like_any_other() -> None:
    """Other batches, numpy, episodes that begin, saved memories, another precision, explanations."""
    policy = follower()
    compiled = policy.compile()

    assert_same_steps(policy, compiled, wandering(4, (3,)), 1e-12)
    assert_same_steps(policy, compiled, wandering(4), 1e-12)

    memory = compiled.predict(wandering(1, (3,))[0])[1]
    strided = {
        name: value.clone().mT.contiguous().mT if value.dim() > 1 else value
        for name, value in memory.items()
    }
    begins = torch.tensor([False, True, False])

    for state in (memory, strided):
        expected = policy.predict(wandering(2, (3,))[1], memory, begins)
        found = compiled.predict(wandering(2, (3,))[1], state, begins)
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
        assert_same_steps(policy, compiled, wandering(6), 0.0)
    assert len(warned) == 1


def test_without_a_compiler_it_runs_uncompiled() -> None:
    config = pytest.importorskip("torch._inductor.config")
    policy = follower()
    compiled = policy.compile()

    with (
        config.patch({"cpp.cxx": ("no-such-compiler",), "force_disable_caches": True}),
        pytest.warns(RuntimeWarning, match=r"runs uncompiled.*C\+\+ compiler") as warned,
    ):
        assert_same_steps(policy, compiled, wandering(6), 0.0)

    assert len(warned) == 1
