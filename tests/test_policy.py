"""Policies: what the motion does to the costs, kinds of numbers, and small graphs."""

from typing import Any

import numpy as np
import pytest
import torch
from _asserts import assert_same_memory, rollout
from _inputs import (
    DTYPES,
    direction,
    drifting,
    lean,
    lengths,
    navigation,
    normal,
    observation_with,
    two_robots,
    with_law,
    with_rule,
)
from torch import Tensor, nn

from aicon_torch import (
    Actuator,
    Deterministic,
    DirectDescent,
    Exploration,
    Foresight,
    Goal,
    NullspaceProjection,
    OptionError,
    Policy,
    Resolution,
    Sensor,
    Sum,
    TrapEscape,
    WorldModel,
)


@pytest.mark.parametrize("projector", ["orthogonal", "qr", "pinv"])
def test_to_first_order_the_motion_never_raises_what_leads(projector: str) -> None:
    """Where the paths meet, the leading path's cost falls, or stays while exploring.

    The second's does not rise in the space that the first leaves to it. Without the low-pass the
    action is −k dt times the resolved gradient at x_rob.
    """
    policy = with_rule(navigation("paper_literal"), projector=projector)
    policy = with_law(policy, accumulate=False, smoothing=0.0)
    explored = []

    for memory in rollout(policy, drifting(50, (4,))):
        gradients, exploring = memory["x_rob/gradients"], memory["x_rob/exploring"]
        units = gradients / lengths(gradients).clamp(min=1e-300).unsqueeze(-1)
        first, second = units.take_along_dim(memory["x_rob/rank"][..., None], dim=-2).unbind(-2)
        motion = direction(memory["a"])

        change = (first * motion).sum(-1)
        assert (change[exploring].abs() < 1e-6).all()
        assert (change[~exploring] < 0).all()

        free = second - (second * first).sum(-1, keepdim=True) * first
        assert ((free * motion).sum(-1)[~exploring] <= 1e-9).all()
        explored.append(exploring)

    assert 0.02 < torch.stack(explored).double().mean() < 0.98


def test_several_actuators_give_a_dict_of_actions() -> None:
    policy = Policy(two_robots(), Sum(), DirectDescent(1.0))
    action, _ = policy.predict({"z": np.zeros(2)})
    assert set(action) == {"a", "b"}
    assert all(isinstance(value, np.ndarray) for value in action.values())


def test_the_rule_names_unknown_goals_when_the_policy_is_built() -> None:
    rule = NullspaceProjection(exploration=Exploration(escape=TrapEscape(hold="home")))
    with pytest.raises(OptionError, match="'home'"):
        Policy(two_robots(), rule)


class Weighted(nn.Module, Resolution):
    """A rule with a weight that somebody wants to learn."""

    def __init__(self) -> None:
        super().__init__()
        self.weight = nn.Parameter(torch.ones(()))

    def initial(self, *given: Any) -> Any:
        return {}

    def __call__(self, *given: Any) -> Any:
        return given


def test_a_rule_that_would_not_learn_is_refused() -> None:
    with pytest.raises(OptionError, match=r"resolution=Weighted.*'weight'.*only.*the model learn"):
        Policy(two_robots(), Weighted())


def test_by_default_a_policy_projects_and_looks_ahead() -> None:
    policy = Policy(two_robots())
    assert policy.resolution == NullspaceProjection()
    assert policy.law == Foresight()
    assert policy.perception is None


def test_a_graph_of_functions_alone_is_a_policy() -> None:
    model = WorldModel(
        sensors={"z": Sensor(2, "m")},
        actuators={"a": Actuator(2, "m", limit=1.0)},
        estimators=[Deterministic("x", lambda a, z: a + z)],
        goals=[Goal("reach", lambda x: (x**2).sum(-1))],
    )

    policy = Policy(model, law=DirectDescent(0.25, smoothing=0.0))
    action, memory = policy.predict({"z": normal(2).numpy()})

    assert np.allclose(action, -0.5 * normal(2).numpy(), atol=1e-6)
    assert memory["x"].dtype == torch.get_default_dtype()


# --- kinds of numbers


def test_actions_are_of_the_kind_of_the_observation() -> None:
    action, memory = navigation().predict(observation_with())
    assert isinstance(action, np.ndarray) and action.dtype == np.float32 and action.shape == (2,)

    tensors = {key: torch.as_tensor(value) for key, value in observation_with().items()}
    action, again = navigation().predict(tensors)
    assert isinstance(action, Tensor) and action.dtype == torch.float64
    assert_same_memory(memory, again, 0.0)

    expected, _ = navigation().predict(observation_with(range=[1.0]))
    for kind in (np.float32, np.int64, bool):
        action, _ = navigation().predict(observation_with(range=np.array([1], dtype=kind)))
        assert np.array_equal(action, expected)


@pytest.mark.parametrize("dtype", DTYPES, ids=str)
def test_every_value_has_the_precision_of_the_model(dtype: torch.dtype) -> None:
    memory = rollout(lean("nav2d", dtype=dtype), drifting(5))[-1]
    assert {value.dtype for value in memory.values() if value.is_floating_point()} == {dtype}


def test_float32_follows_float64() -> None:
    """In a step from the same memory: in the first ones a direction may rest on rounding."""
    *before, observation = drifting(10)
    memory = rollout(navigation(), before)[-1]
    rounded = {key: to_float32(value) for key, value in memory.items()}

    _, double = navigation().predict(observation, memory)
    _, single = lean("nav2d", dtype=torch.float32).predict(observation, rounded)

    for key in ("p_tar", "P_tar", "x_obs", "a"):
        torch.testing.assert_close(single[key].double(), double[key], rtol=2e-3, atol=2e-3)


def to_float32(value: Tensor) -> Tensor:
    return value.float() if value.is_floating_point() else value


def test_the_ambient_gradient_mode_does_not_matter() -> None:
    recorded = drifting(5)
    expected = rollout(navigation(), recorded)[-1]

    for mode in (torch.no_grad(), torch.enable_grad(), torch.inference_mode()):
        with mode:
            assert_same_memory(rollout(navigation(), recorded)[-1], expected, 0.0)
