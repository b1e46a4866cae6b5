"""The compiled policy takes the steps of the one it is made of."""

from concurrent.futures import ThreadPoolExecutor

import pytest
import torch
from _asserts import assert_same_steps
from _asserts.roundings import assert_equal_but_for_roundings
from _inputs import drifting, driven, lean
from _inputs.following import Readings, follower, passing, wandering
from torch import Tensor

from aicon_torch import OptionError, Policy, make_policy
from aicon_torch.export.codegen import has_compiler
from aicon_torch.export.exported_memory import ExportedMemory

with_compiler = pytest.mark.skipif(not has_compiler(), reason="there is no C compiler")


@with_compiler
@pytest.mark.parametrize(
    ("policy", "readings"),
    [
        pytest.param(follower(), wandering(12), id="follower"),
        pytest.param(lean("nav2d"), drifting(24, (3,)), id="nav2d"),
        pytest.param(follower().to(torch.float32), wandering(12), id="in float32"),
        pytest.param(lean("pusht"), passing(8, (2,)), id="pusht"),
    ],
)
def test_it_takes_the_same_steps(policy: Policy, readings: Readings) -> None:
    assert_same_steps(policy, policy.compile(), readings)


@with_compiler
def test_it_takes_the_same_steps_of_twenty_gradients() -> None:
    """As it is shipped; the others above take two."""
    assert_same_steps(make_policy("nav2d"), driven("nav2d"), drifting(6))


@with_compiler
@pytest.mark.slow
@pytest.mark.usefixtures("optimized")
@pytest.mark.parametrize(
    ("name", "readings"), [("nav2d", drifting(150, (3,))), ("pusht", passing(30, (2,)))]
)
def test_it_takes_the_same_steps_as_shipped(name: str, readings: Readings) -> None:
    policy = make_policy(name)
    assert_same_steps(policy, policy.compile(), readings)


@with_compiler
def test_single_precision_is_as_near_to_double_precision_as_without_compiling() -> None:
    """A step of many gradients amplifies what either rounds, so they may not be near each other."""
    exact = lean("nav2d")
    single = lean("nav2d", dtype=torch.float32)
    compiled, memory = single.compile(), None

    for reading in drifting(20):
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
def test_a_first_step_in_inference_mode_is_compiled_to_c_as_well() -> None:
    """As LeRobot takes it."""
    policy, reading = follower(), wandering(1)[0]
    with torch.inference_mode():
        action, memory = policy.compile().predict(reading)
    assert isinstance(memory, ExportedMemory)
    torch.testing.assert_close(action, policy.predict(reading)[0])


@with_compiler
@pytest.mark.slow
def test_the_arm_takes_the_same_steps() -> None:
    """What it sees is read outside the part that is compiled."""
    panda = pytest.importorskip("aicon_envs.arm_push", reason="the arm needs MuJoCo")
    env, policy, memory = panda.ArmPushEnv(), make_policy("arm_push"), None
    compiled = policy.compile()

    try:
        observation, _ = env.reset(seed=1000)
    except RuntimeError as error:
        pytest.skip(str(error))

    # The readable step, which is slow, is taken at some of them.
    for step in range(120):
        before = memory
        action, memory = compiled.predict(observation, before)
        if step % 12 == 0:
            assert_equal_but_for_roundings(policy, observation, before, memory)
        observation, *_ = env.step(action)
    env.close()


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


@with_compiler
def test_a_constant_of_the_graph_that_has_changed_is_told() -> None:
    """As load_state_dict() changes it; the step in C has the old one."""
    compiled, reading = follower().compile(), wandering(1)[0]
    compiled.predict(reading)
    changed = {name: 2.0 * value for name, value in compiled.state_dict().items()}
    compiled.load_state_dict(changed)
    with pytest.raises(OptionError, match=r"buffers changed.*compile\(\) again"):
        compiled.predict(reading)


@with_compiler
def test_many_threads_may_take_the_first_step_at_once() -> None:
    compiled, reading = follower().compile(), wandering(1)[0]
    with ThreadPoolExecutor(4) as threads:
        actions = list(threads.map(lambda _: compiled.predict(reading)[0], range(4)))
    assert all(torch.equal(action, actions[0]) for action in actions)
