"""Policies: memory goes in and comes out, bad observations are named, rows and episodes are independent."""

import io
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pytest
import torch
from _asserts import assert_rows_stand_alone, assert_same_memory, rollout
from _inputs import DTYPES, drifting, normal
from hypothesis import given, settings
from hypothesis import strategies as st
from torch import Tensor

from aicon_torch import (
    ActionLaw,
    Actuator,
    Affine,
    Exploration,
    Deterministic,
    Goal,
    KalmanFilter,
    Measurement,
    NullspaceProjection,
    ObservationError,
    OptionError,
    Policy,
    Sensor,
    Sum,
    WorldModel,
    make_policy,
)
from aicon_torch.models import presets

PRESETS = presets("nav2d")
POLICIES = {name: make_policy("nav2d", preset=name) for name in PRESETS}


def seen(**changes: Any) -> dict[str, Any]:
    return {"bearing": np.array([0.3]), "range": np.array([1.0])} | changes


def arrays(observation: Mapping[str, Tensor]) -> dict[str, np.ndarray[Any, Any]]:
    return {name: reading.numpy() for name, reading in observation.items()}


# --- rows, episodes, memory


@pytest.mark.parametrize("preset", ["aicon", "paper_literal", "steepest", "potential_field", "no_softmax"])
def test_singles_are_rows_of_a_batch(preset: str) -> None:
    assert_rows_stand_alone(POLICIES[preset], drifting(100, (3,)), rows=(0, 2))


def test_the_batch_may_have_any_number_of_dimensions() -> None:
    recorded = drifting(20, (2, 3))
    grid = rollout(POLICIES["aicon"], recorded)[-1]
    flat = rollout(POLICIES["aicon"], [{k: v.reshape(6, 1) for k, v in reading.items()} for reading in recorded])[-1]
    for key, value in grid.items():
        assert value.shape[:2] == (2, 3)
        torch.testing.assert_close(value.flatten(0, 1), flat[key], rtol=1e-12, atol=1e-12)


def test_the_recorded_readings_make_it_explore() -> None:
    """Else the tests above and below would show little."""
    memories = rollout(POLICIES["aicon"], drifting(120, (3,)))
    exploring = torch.stack([memory["x_rob/exploring"] for memory in memories])
    assert 0.05 < exploring.double().mean() < 0.95


@pytest.mark.parametrize("preset", ["aicon", "paper_literal", "steepest"])
def test_an_episode_goes_on_after_saving_and_loading(preset: str) -> None:
    policy, recorded = POLICIES[preset], drifting(80)
    straight = rollout(policy, recorded)
    saved = io.BytesIO()
    torch.save(straight[39], saved)
    saved.seek(0)
    memory = torch.load(saved, weights_only=True)
    other = make_policy("nav2d", preset=preset)
    for step in range(40, 80):
        _, memory = other.predict(recorded[step], memory)
        for key, value in straight[step].items():
            assert torch.equal(memory[key], value)


def test_the_memory_is_flat_and_carries_no_graph() -> None:
    for preset in PRESETS:
        for memory in rollout(POLICIES[preset], drifting(3, (2,))):
            for value in memory.values():
                assert isinstance(value, Tensor) and not value.requires_grad and value.shape[0] == 2


def test_predict_does_not_change_what_it_is_given() -> None:
    recorded = drifting(30, (2,))
    memory = rollout(POLICIES["aicon"], recorded)[-1]
    before = {key: value.clone() for key, value in memory.items()}
    POLICIES["aicon"].predict(recorded[0], memory, episode_start=torch.tensor([True, False]))
    POLICIES["aicon"].switch(memory, reach=False)
    assert_same_memory(memory, before, 0.0)


@pytest.mark.parametrize("kind", ["numpy", "list", "tensor"])
def test_only_the_rows_that_start_forget(kind: str) -> None:
    policy, recorded = POLICIES["aicon"], drifting(41, (3,))
    memory = rollout(policy, recorded[:40])[-1]
    start: Any = {
        "numpy": np.array([False, True, False]),
        "list": [False, True, False],
        "tensor": torch.tensor([False, True, False]),
    }[kind]
    _, after = policy.predict(recorded[40], memory, episode_start=start)
    _, going_on = policy.predict(recorded[40], memory)
    _, anew = policy.predict(recorded[40])
    for key, value in after.items():
        torch.testing.assert_close(value[0], going_on[key][0])
        torch.testing.assert_close(value[2], going_on[key][2])
        torch.testing.assert_close(value[1], anew[key][1])
    assert not torch.equal(after["p_tar"][1], going_on["p_tar"][1])


@pytest.mark.parametrize("start", [True, np.True_, np.array(True), np.array([True]), torch.tensor(True)], ids=repr)
def test_a_single_robot_may_start_anew(start: Any) -> None:
    """Without batch dimensions too, and with the one-row array that a loop over one environment has."""
    policy, recorded = POLICIES["aicon"], drifting(21)
    memory = rollout(policy, recorded[:20])[-1]
    _, after = policy.predict(recorded[20], memory, episode_start=start)
    assert_same_memory(after, policy.predict(recorded[20])[1], 0.0)


@pytest.mark.parametrize("start", [False, np.array([False]), [False], None])
def test_without_a_start_it_goes_on(start: Any) -> None:
    policy, recorded = POLICIES["aicon"], drifting(21)
    memory = rollout(policy, recorded[:20])[-1]
    _, after = policy.predict(recorded[20], memory, episode_start=start)
    assert_same_memory(after, policy.predict(recorded[20], memory)[1], 0.0)


def test_the_first_memory_ignores_episode_start() -> None:
    recorded = drifting(1, (3,))[0]
    for start in (np.ones(3, bool), np.zeros(3, bool), None):
        assert_same_memory(
            POLICIES["aicon"].predict(recorded, None, start)[1], POLICIES["aicon"].predict(recorded)[1], 0.0
        )


def test_act_and_reset_are_predict_with_the_memory_kept() -> None:
    policy = make_policy("nav2d")
    for _ in range(2):
        memory = None
        for reading in drifting(30):
            action, memory = policy.predict(arrays(reading), memory)
            assert np.array_equal(policy.act(arrays(reading)), action)
        policy.reset()


def test_one_policy_serves_several_episodes_at_once() -> None:
    """No step leaves anything behind in the policy."""
    policy, first, second = POLICIES["aicon"], drifting(40, seed=1), drifting(40, seed=5)
    alone = rollout(policy, first)
    memories: list[Any] = [None, None]
    for step in range(40):
        for episode, recorded in enumerate((first, second)):
            _, memories[episode] = policy.predict(recorded[step], memories[episode])
        assert_same_memory(memories[0], alone[step], 0.0)


# --- what the motion does to the costs


@pytest.mark.parametrize("projector", ["orthogonal", "qr", "pinv"])
def test_to_first_order_the_motion_never_raises_what_leads(projector: str) -> None:
    """Resolved where the paths meet: the leading path's cost falls, or stays while exploring, the second's too.

    Without the low-pass the action is −k dt times the resolved gradient at x_rob.
    """
    policy = make_policy("nav2d", preset="paper_literal", projector=projector, accumulate=False, smoothing=0.0)
    explored = []
    for memory in rollout(policy, drifting(150, (4,))):
        rank, gradients = memory["x_rob/rank"], memory["x_rob/gradients"]
        lengths = gradients.norm(dim=-1, keepdim=True)
        units = gradients / lengths.clamp(min=1e-300)
        first = units.take_along_dim(rank[:, :1, None], dim=-2).squeeze(-2)
        direction = memory["a"] / memory["a"].norm(dim=-1, keepdim=True)
        change = (first * direction).sum(-1)
        exploring = memory["x_rob/exploring"]
        assert (change[exploring].abs() < 1e-6).all()
        assert (change[~exploring] < 0).all()
        second = units.take_along_dim(rank[:, 1:2, None], dim=-2).squeeze(-2)
        free = second - (second * first).sum(-1, keepdim=True) * first
        assert ((free * direction).sum(-1)[~exploring] <= 1e-9).all()
        explored.append(exploring)
    assert 0.02 < torch.stack(explored).double().mean() < 0.98


# --- kinds of numbers


def test_actions_are_of_the_kind_of_the_observation() -> None:
    action, memory = POLICIES["aicon"].predict(seen())
    assert isinstance(action, np.ndarray) and action.dtype == np.float32 and action.shape == (2,)
    action, again = POLICIES["aicon"].predict({key: torch.as_tensor(value) for key, value in seen().items()})
    assert isinstance(action, Tensor) and action.dtype == torch.float64
    assert_same_memory(memory, again, 0.0)
    for kind in (np.float32, np.int64, bool):
        action, _ = POLICIES["aicon"].predict(seen(range=np.array([1], dtype=kind)))
        assert np.array_equal(action, POLICIES["aicon"].predict(seen(range=[1.0]))[0])


@pytest.mark.parametrize("dtype", DTYPES, ids=str)
def test_every_value_has_the_precision_of_the_model(dtype: torch.dtype) -> None:
    memory = rollout(make_policy("nav2d", dtype=dtype), drifting(30))[-1]
    assert {value.dtype for value in memory.values() if value.is_floating_point()} == {dtype}


def test_float32_follows_float64() -> None:
    """At the start; a closed loop would drift apart later."""
    recorded = drifting(10)
    single = rollout(make_policy("nav2d", dtype=torch.float32), recorded)[-1]
    double = rollout(POLICIES["aicon"], recorded)[-1]
    for key in ("p_tar", "P_tar", "x_obs", "a"):
        torch.testing.assert_close(single[key].double(), double[key], rtol=2e-3, atol=2e-3)


def test_the_ambient_gradient_mode_does_not_matter() -> None:
    recorded = drifting(5)
    expected = rollout(POLICIES["aicon"], recorded)[-1]
    for mode in (torch.no_grad(), torch.enable_grad(), torch.inference_mode()):
        with mode:
            assert_same_memory(rollout(POLICIES["aicon"], recorded)[-1], expected, 0.0)


def test_several_actuators_give_a_dict_of_actions() -> None:
    policy = Policy(two_robots(), Sum(), ActionLaw(1.0))
    action, _ = policy.predict({"z": np.zeros(2)})
    assert set(action) == {"a", "b"} and all(isinstance(value, np.ndarray) for value in action.values())


def two_robots() -> WorldModel:
    def meet(x: Tensor, b: Tensor) -> Tensor:
        return ((x - b - 1.0) ** 2).sum(-1)

    track = KalmanFilter("x", "P", predict=Affine(x=1.0, a=0.1), noise=0.1, initial=((0.0, 0.0), 1.0), correct=[
        Measurement(Affine(x=1.0, z=-1.0), 0.1, size=2)
    ])  # fmt: skip
    return WorldModel(
        sensors={"z": Sensor(2, "m")},
        actuators={"a": Actuator(2, "m/s", 0.5), "b": Actuator(2, "m", (1.0, 2.0))},
        estimators=[track],
        goals=[Goal("meet", meet)],
        dtype=torch.float64,
    )


# --- constraints and commands


def slower(a: Tensor) -> Tensor:
    return 0.5 * a


def rightward(a: Tensor) -> Tensor:
    return a + torch.tensor([1.0, 0.0], dtype=a.dtype)


def off_the_wall(a: Tensor, x: Tensor, wall: Tensor, dt: float) -> Tensor:
    """No farther to the right than the wall, of which a sensor tells."""
    return torch.cat((torch.minimum(a[..., :1], (wall - x[..., :1]) / dt), a[..., 1:]), dim=-1)


def where_to(a: Tensor, x: Tensor, dt: float) -> Tensor:
    return x + a * dt


def steered(constraints: Sequence[Any] = (), command: Any = None, goal: tuple[float, float] = (3.0, -1.0)) -> Policy:
    """A point that goes to a goal with at most 2 m/s."""

    def reach(x: Tensor) -> Tensor:
        return ((x - x.new_tensor(goal)) ** 2).sum(-1)

    track = KalmanFilter("x", "P", predict=Affine(x=1.0, a=0.1), noise=0.1, initial=((0.0, 0.0), 1.0), correct=[
        Measurement(Affine(x=1.0, z=-1.0), 0.1, size=2)
    ])  # fmt: skip
    model = WorldModel(
        sensors={"z": Sensor(2, "m"), "wall": Sensor(1, "m")},
        actuators={"a": Actuator(2, "m/s", 2.0, constraints, command)},
        estimators=[track],
        goals=[Goal("reach", reach)],
        dt=0.1,
        dtype=torch.float64,
    )
    return Policy(model, Sum(), ActionLaw(10.0))


def walled(steps: int, batch: tuple[int, ...] = (), wall: float = 0.1) -> list[dict[str, Tensor]]:
    return [
        {"z": 0.1 * normal(*batch, 2, seed=seed), "wall": torch.full((*batch, 1), wall, dtype=torch.float64)}
        for seed in range(steps)
    ]


def test_constraints_act_one_after_the_other() -> None:
    (reading,) = walled(1)
    free = steered().predict(reading)[0]
    assert torch.equal(steered([slower]).predict(reading)[0], 0.5 * free)
    one, other = (steered(pair).predict(reading)[0] for pair in ([slower, rightward], [rightward, slower]))
    right = torch.tensor([1.0, 0.0], dtype=torch.float64)
    torch.testing.assert_close(one, 0.5 * free + right)
    torch.testing.assert_close(other, 0.5 * (free + right))


def test_a_constraint_reads_what_the_step_has_estimated() -> None:
    """The estimate after this reading, not the last one, and a sensor's reading that no estimator reads."""
    policy = steered([off_the_wall])
    memory, active = None, []
    for reading in walled(30):
        action, memory = policy.predict(reading, memory)
        room = (reading["wall"] - memory["x"][:1]) / 0.1
        assert action[:1] <= room
        active.append(bool(action[:1] == room))
    assert 0 < sum(active) < len(active)


def test_the_memory_holds_the_constrained_action_and_the_robot_gets_the_command() -> None:
    """The action is what the estimates go on with; the command is what is sent."""
    policy, plain = steered([slower], where_to), steered([slower])
    memory = other = None
    for reading in walled(5):
        command, memory = policy.predict(reading, memory)
        action, other = plain.predict(reading, other)
        assert_same_memory(memory, other, 0.0)
        assert torch.equal(memory["a"], action) and memory["a"].norm() <= 1.0
        torch.testing.assert_close(command, memory["x"] + 0.1 * action)


def test_the_next_step_starts_from_the_constrained_action() -> None:
    """The low-pass smooths what was done, and the prediction moves by it."""
    policy = steered([slower])
    first, second = walled(2)
    _, memory = policy.predict(first)
    done, _ = policy.predict(second, memory)
    wish = steered().predict(second, memory)[0]  # without constraint from the same memory
    torch.testing.assert_close(done, 0.5 * wish)
    faked = policy.predict(second, memory | {"a": 2.0 * memory["a"]})[1]
    assert not torch.allclose(faked["x"], policy.predict(second, memory)[1]["x"])


def test_commands_are_of_the_kind_of_the_observation() -> None:
    policy = steered([slower], where_to)
    (reading,) = walled(1)
    command, memory = policy.predict(arrays(reading))
    assert isinstance(command, np.ndarray) and command.dtype == np.float32
    expected, same = policy.predict(reading)
    assert isinstance(expected, Tensor) and expected.dtype == torch.float64
    assert np.array_equal(command, expected.numpy().astype(np.float32))
    assert_same_memory(memory, same, 0.0)
    assert np.array_equal(policy.act(arrays(reading)), command)


def test_a_command_may_have_another_size() -> None:
    def polar(a: Tensor) -> Tensor:
        return torch.cat((a, a.norm(dim=-1, keepdim=True)), dim=-1)

    for batch in ((), (4,)):
        (reading,) = walled(1, batch)
        command, memory = steered(command=polar).predict(reading)
        torch.testing.assert_close(command, polar(memory["a"]))


def test_constrained_singles_are_rows_of_a_batch() -> None:
    policy, recorded = steered([off_the_wall, slower], where_to), walled(10, (3,))
    assert_rows_stand_alone(policy, recorded, rows=(0, 2))
    together, _ = policy.predict(recorded[0])
    for row in range(3):
        alone, _ = policy.predict({name: value[row] for name, value in recorded[0].items()})
        torch.testing.assert_close(alone, together[row])


def test_constraints_hold_for_what_the_policy_does_and_not_for_what_was_done() -> None:
    """An action that somebody else executed moves the estimates as it is."""
    recorded = walled(3)
    executed = {"a": torch.tensor([30.0, -40.0], dtype=torch.float64)}
    plain, limited = steered(), steered([slower, off_the_wall], where_to)
    for policy in (plain, limited):
        memory = policy.estimate(recorded[0], None, executed)
        assert torch.equal(memory["a"], executed["a"])
    watched = [policy.estimate(recorded[1], policy.estimate(recorded[0]), executed) for policy in (plain, limited)]
    assert_same_memory(watched[0], watched[1], 0.0)
    memory = limited.predict(recorded[0])[1]
    assert torch.equal(limited.estimate(recorded[1], memory)["a"], memory["a"])


def test_each_actuator_has_its_own() -> None:
    def meet(x: Tensor, y: Tensor) -> Tensor:
        return ((x - y - 1.0) ** 2).sum(-1)

    def follows(b: Tensor, a: Tensor) -> Tensor:
        return torch.maximum(b, -0.5 * a.abs())  # of a as it was constrained

    model = WorldModel(
        sensors={"z": Sensor(2, "m")},
        actuators={
            "a": Actuator(2, "m", constraints=[slower]),
            "b": Actuator(2, "m", constraints=[follows], command=lambda b: 10.0 * b),
        },
        estimators=[Deterministic("x", lambda a, z: a + z), Deterministic("y", lambda b: 1.0 * b)],
        goals=[Goal("meet", meet)],
        dtype=torch.float64,
    )
    action, memory = Policy(model, Sum(), ActionLaw(1.0, smoothing=0.0)).predict({"z": np.zeros(2)})
    assert memory["a"].tolist() == [1.0, 1.0]
    assert memory["b"].tolist() == [-0.5, -0.5]
    assert action["a"].tolist() == [1.0, 1.0] and action["b"].tolist() == [-5.0, -5.0]


def test_a_constraint_with_parameters_leaves_no_graph_in_the_memory() -> None:
    class Learned(torch.nn.Module):
        def __init__(self) -> None:
            super().__init__()
            self.factor = torch.nn.Parameter(torch.tensor(0.5, dtype=torch.float64))

        def forward(self, a: Tensor) -> Tensor:
            return self.factor * a

    policy = steered([Learned()])
    _, memory = policy.predict(walled(1)[0])
    assert not [name for name, value in memory.items() if value.requires_grad]


def test_a_constraint_follows_the_precision_of_the_model() -> None:
    class Shifted(torch.nn.Module):
        def __init__(self) -> None:
            super().__init__()
            self.register_buffer("shift", torch.ones(2))

        def forward(self, a: Tensor) -> Tensor:
            return a + self.shift  # type: ignore[operator]  # a buffer

    policy = steered([Shifted()])
    assert [buffer.dtype for name, buffer in policy.named_buffers() if name.endswith("shift")] == [torch.float64]


def test_a_reading_that_requires_a_gradient_leaves_no_graph_in_the_memory() -> None:
    reading = {name: value.requires_grad_() for name, value in walled(1)[0].items()}
    for policy in (steered(), steered([off_the_wall])):
        _, memory = policy.predict(reading)
        assert not [name for name, value in memory.items() if value.requires_grad]


# --- estimation alone


def test_estimates_without_acting_are_those_of_predict() -> None:
    policy, recorded = POLICIES["aicon"], drifting(60, (2,))
    memory = watching = None
    for reading in recorded:
        executed = None if memory is None else {"a": memory["a"]}
        watching = policy.estimate(reading, watching, executed)
        _, memory = policy.predict(reading, memory)
        for name in ("p_tar", "P_tar", "x_obs", "P_obs"):
            torch.testing.assert_close(watching[name], memory[name], rtol=1e-12, atol=1e-12)
    assert watching is not None and memory is not None and watching.keys() == memory.keys()


def test_acting_can_begin_after_watching() -> None:
    policy, recorded = POLICIES["aicon"], drifting(20)
    memory = None
    for reading in recorded[:10]:
        memory = policy.estimate(reading, memory, {"a": torch.tensor([0.1, 0.0], dtype=torch.float64)})
    _, after = policy.predict(recorded[10], memory)
    assert after["a"].isfinite().all()
    assert memory is not None and after.keys() == memory.keys()


def test_the_given_action_moves_the_estimates() -> None:
    policy, recorded = POLICIES["aicon"], drifting(2)
    start = policy.estimate(recorded[0])
    moved = policy.estimate(recorded[1], start, {"a": torch.tensor([0.5, 0.0], dtype=torch.float64)})
    assert torch.equal(moved["x_rob"], torch.tensor([0.025, 0.0], dtype=torch.float64))
    at_rest = policy.estimate(recorded[1], start)
    assert not at_rest["x_rob"].any()


def test_estimation_starts_episodes_too() -> None:
    policy, recorded = POLICIES["aicon"], drifting(11, (2,))
    memory = None
    for reading in recorded[:10]:
        memory = policy.estimate(reading, memory)
    after = policy.estimate(recorded[10], memory, episode_start=np.array([True, False]))
    torch.testing.assert_close(after["p_tar"][0], policy.estimate(recorded[10])["p_tar"][0])
    torch.testing.assert_close(after["p_tar"][1], policy.estimate(recorded[10], memory)["p_tar"][1])


@pytest.mark.parametrize("limit", [0.5, (0.5, 0.3)], ids=str)
def test_the_limit_holds_after_somebody_else_was_faster(limit: Any) -> None:
    model = WorldModel(
        sensors={"z": Sensor(2, "m")},
        actuators={"a": Actuator(2, "m/s", limit)},
        estimators=[Deterministic("x", lambda a, z: a + z)],
        goals=[Goal("reach", lambda x: (x**2).sum(-1))],
        dtype=torch.float64,
    )
    for law in (ActionLaw(1.0), ActionLaw(1.0, accumulate=True), ActionLaw(1.0, smoothing=0.0)):
        policy = Policy(model, Sum(), law)
        pushed = policy.estimate({"z": np.ones(2)}, action={"a": torch.tensor([30.0, -40.0], dtype=torch.float64)})
        action, _ = policy.predict({"z": np.ones(2)}, pushed)
        assert (np.abs(action) <= 0.5).all() and np.linalg.norm(action) <= np.linalg.norm(limit) + 1e-6


def test_an_unknown_actuator_is_named() -> None:
    with pytest.raises(OptionError, match=r"'v'.*'a'"):
        POLICIES["aicon"].estimate(seen(), action={"v": torch.zeros(2)})


# --- switching goals


def test_a_goal_can_be_switched_off_and_on() -> None:
    policy, recorded = POLICIES["potential_field"], drifting(3)
    memory = rollout(policy, recorded[:2])[-1]
    off = policy.predict(recorded[2], policy.switch(memory, avoid=False))[1]
    gradients = off["x_rob/gradients"]
    assert [bool(gradient.any()) for gradient in gradients] == [
        "avoid" not in str(arrival) for arrival in policy.backward_pass.arrivals["x_rob"]
    ]
    on = policy.predict(recorded[2], policy.switch(policy.switch(memory, avoid=False), avoid=True))[1]
    assert_same_memory(on, policy.predict(recorded[2], memory)[1], 0.0)
    nothing = policy.predict(recorded[2], policy.switch(memory, avoid=False, reach=0.0))[1]
    assert not nothing["a/gradient"].any()


def test_a_switch_stays_until_changed_and_is_of_each_row() -> None:
    policy, recorded = POLICIES["aicon"], drifting(60, (2,))
    memory = rollout(policy, recorded[:40])[-1]
    memory = policy.switch(memory, avoid=torch.tensor([0.0, 1.0]))
    expected = rollout(policy, recorded)
    for reading, whole in zip(recorded[40:], expected[40:], strict=True):
        _, memory = policy.predict(reading, memory)
        torch.testing.assert_close(memory["a"][1], whole["a"][1])
    assert not torch.allclose(memory["a"][0], expected[-1]["a"][0])


def test_a_switch_outlasts_the_episode() -> None:
    policy, recorded = POLICIES["aicon"], drifting(5, (2,))
    memory = policy.switch(rollout(policy, recorded[:4])[-1], avoid=0.0)
    _, after = policy.predict(recorded[4], memory, episode_start=np.array([True, False]))
    assert torch.equal(after["goals/active"], memory["goals/active"])
    assert not after["x_rob/gradients"][
        :, [str(a) for a in policy.backward_pass.arrivals["x_rob"]].index("avoid → x_obs")
    ].any()


def test_an_unknown_goal_is_named() -> None:
    _, memory = POLICIES["aicon"].predict(seen())
    with pytest.raises(OptionError, match=r"'reech'.*'reach', 'avoid'"):
        POLICIES["aicon"].switch(memory, reech=False)


def test_a_goal_about_uncertainty_can_be_descended_alone() -> None:
    """Seen along one axis only, the robot moves so as to see the other: the paper's triangulation."""
    policy, reading = POLICIES["potential_field"], drifting(2)
    memory = rollout(policy, reading)[-1]
    slope = memory["x_rob/gradients"][
        [str(arrival) for arrival in policy.backward_pass.arrivals["x_rob"]].index("reach → P_tar")
    ]
    across = torch.tensor([-memory["p_tar"][1], memory["p_tar"][0]]).double()
    assert (slope @ across).abs() > 3.0 * (slope @ memory["p_tar"]).abs()


# --- observations


@pytest.mark.parametrize(
    ("observation", "culprit"),
    [
        (seen(range=np.array([np.nan])), r"'z_obs'.*finite values in m"),
        (seen(bearing=np.array([np.inf])), r"'z_tar'.*finite values in rad"),
        (seen(bearing=np.array([-np.inf])), r"'z_tar'"),
        ({"range": np.array([1.0])}, r"'z_tar'.*no 'bearing'.*'range'.*\(\*batch, 1\) in rad"),
        ({}, r"'z_tar'.*no 'bearing'"),
        (seen(range=np.array([1.0, 2.0])), r"'z_obs'.*expected shape \(.*1\), got \(2,\)"),
        (seen(range=np.array(1.0)), r"'z_obs'.*got \(\)"),
        (seen(range=np.array([[1.0]])), r"'z_obs'.*got \(1, 1\)"),
        (seen(range=np.ones((3, 1))), r"'z_obs'.*got \(3, 1\)"),
        (seen(range=np.array(["near"])), r"'z_obs'.*numbers in m"),
        (seen(range=None), r"'z_obs'.*numbers in m"),
        (seen(range=np.array([1.0j])), r"'z_obs'.*numbers in m"),
        (seen(range=np.array([None])), r"'z_obs'.*numbers in m"),
        (seen(bearing=[[0.1], [0.2, 0.3]]), r"'z_tar'"),
        (seen(range=torch.ones(3, 1)), r"'z_obs'.*got \(3, 1\)"),
        (np.array([0.3, 1.0]), "expected an observation by sensor"),
        (None, "expected an observation by sensor"),
    ],
)
def test_a_bad_observation_is_refused_by_sensor(observation: Any, culprit: str) -> None:
    _, memory = POLICIES["aicon"].predict(seen())
    for state in (None, memory):
        with pytest.raises(ObservationError, match=culprit):
            POLICIES["aicon"].predict(observation, state)
        with pytest.raises(ObservationError, match=culprit):
            POLICIES["aicon"].estimate(observation, state)


def test_bad_rows_of_a_batch_are_refused() -> None:
    with pytest.raises(ObservationError, match="'z_obs'"):
        POLICIES["aicon"].predict(seen(bearing=np.zeros((2, 1)), range=np.array([[1.0], [np.nan]])))


def test_optional_readings_may_be_anything_that_is_no_number() -> None:
    reach = Goal("reach", lambda x: (x**2).sum(-1))
    model = WorldModel(
        sensors={"z": Sensor(2, "m", key="camera", optional=True), "w": Sensor(1, "m")},
        actuators={"a": Actuator(2, "m/s")},
        estimators=[
            KalmanFilter("x", "P", predict=Affine(x=1.0, a=0.1), noise=0.1, initial=((1.0, 1.0), 1.0), correct=[
                Measurement(Affine(x=1.0, z=-1.0), 0.1, size=2)
            ])
        ],
        goals=[reach],
    )  # fmt: skip
    policy = Policy(model, Sum(), ActionLaw(1.0))
    here = {"w": np.zeros(1)}
    expected = policy.predict(here)[0]
    for nothing in (np.array([np.nan, np.nan]), np.array([np.inf, 0.0]), np.array([0.0, np.nan])):
        assert np.array_equal(policy.predict(here | {"camera": nothing})[0], expected)
    with pytest.raises(ObservationError, match=r"'z'.*got \(3,\)"):
        policy.predict(here | {"camera": np.zeros(3)})


def test_readings_saturate_at_the_sensor_s_range() -> None:
    far, farther = (POLICIES["aicon"].predict(seen(range=np.array([r])))[1] for r in (1e3, 1e30))
    assert_same_memory(far, farther, 0.0)


def test_what_no_sensor_reads_is_ignored() -> None:
    more = seen(position=np.array([np.nan, 1.0]), target="there")
    assert_same_memory(POLICIES["aicon"].predict(seen())[1], POLICIES["aicon"].predict(more)[1], 0.0)


EXTREME = st.floats(allow_nan=False, allow_infinity=False, width=32) | st.sampled_from(
    [0.0, -0.0, 1e-300, 1e-30, 0.13, 0.2, 1.0, 20.0, 1e6, 1e30, 3e38, -3e38, np.pi, -np.pi, 4.0]
)


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("dtype", DTYPES, ids=str)
@settings(max_examples=8)
@given(st.lists(st.tuples(EXTREME, EXTREME), min_size=1, max_size=8))
def test_no_finite_readings_make_a_bad_action(
    preset: str, dtype: torch.dtype, recorded: list[tuple[float, float]]
) -> None:
    policy = make_policy("nav2d", preset=preset, dtype=dtype, max_speed=0.3)
    memory = None
    for bearing, clearance in recorded:
        action, memory = policy.predict({"bearing": np.array([bearing]), "range": np.array([clearance])}, memory)
        assert np.isfinite(action).all()
        assert np.linalg.norm(action) <= 0.3 * (1 + 1e-6)
        assert (np.abs(action) <= np.float32(0.3)).all()
        assert all(value.isfinite().all() for value in memory.values() if value.is_floating_point())


@pytest.mark.parametrize("dtype", DTYPES, ids=str)
@settings(max_examples=10)
@given(st.lists(st.tuples(st.floats(-np.pi, np.pi), st.floats(0.0, 20.0)), min_size=10, max_size=20))
def test_no_plausible_readings_make_a_bad_action(dtype: torch.dtype, recorded: list[tuple[float, float]]) -> None:
    for preset in ("aicon", "paper_literal"):
        policy = make_policy("nav2d", preset=preset, dtype=dtype)
        memory = None
        for bearing, clearance in recorded:
            action, memory = policy.predict({"bearing": np.array([bearing]), "range": np.array([clearance])}, memory)
            assert np.isfinite(action).all() and np.linalg.norm(action) <= 0.5 * (1 + 1e-6)


# --- what does not fit


@pytest.mark.parametrize(("batch", "other"), [((), (3,)), ((3,), ()), ((3,), (2,)), ((2, 3), (6,))], ids=str)
def test_a_memory_of_another_batch_is_named(batch: tuple[int, ...], other: tuple[int, ...]) -> None:
    _, memory = POLICIES["aicon"].predict(drifting(1, batch)[0])
    with pytest.raises(ObservationError, match=r"state.*\(.*\).*\(.*\)"):
        POLICIES["aicon"].predict(drifting(1, other)[0], memory)


def test_a_memory_of_another_policy_is_named() -> None:
    _, memory = POLICIES["steepest"].predict(seen())
    with pytest.raises(ObservationError, match=r"state.*lacks .*'x_rob/exploring'.*'a/gradients'"):
        POLICIES["aicon"].predict(seen(), memory)
    with pytest.raises(ObservationError, match="'p_tar'"):
        POLICIES["aicon"].predict(seen(), {key: value for key, value in memory.items() if key != "p_tar"})


@pytest.mark.parametrize("action", [torch.zeros(3), torch.tensor([0.0, torch.nan]), torch.tensor([torch.inf, 0.0])])
def test_an_executed_action_that_cannot_be_is_named(action: Tensor) -> None:
    with pytest.raises(ObservationError, match=r"'a'.*finite values of shape \(\*batch, 2\)"):
        POLICIES["aicon"].estimate(seen(), action={"a": action})


def test_a_start_of_another_batch_is_named() -> None:
    _, memory = POLICIES["aicon"].predict(drifting(1, (3,))[0])
    with pytest.raises(ObservationError, match=r"episode_start.*\(3,\).*\(2,\)"):
        POLICIES["aicon"].predict(drifting(1, (3,))[0], memory, episode_start=np.ones(2, dtype=bool))


def test_the_rule_names_unknown_goals_when_the_policy_is_built() -> None:
    from aicon_torch import Escape

    with pytest.raises(OptionError, match="'home'"):
        Policy(two_robots(), NullspaceProjection(exploration=Exploration(escape=Escape(hold="home"))), ActionLaw(1.0))


def test_a_graph_of_functions_alone_is_a_policy() -> None:
    model = WorldModel(
        sensors={"z": Sensor(2, "m")},
        actuators={"a": Actuator(2, "m", limit=1.0)},
        estimators=[Deterministic("x", lambda a, z: a + z)],
        goals=[Goal("reach", lambda x: (x**2).sum(-1))],
    )
    action, memory = Policy(model, NullspaceProjection(), ActionLaw(0.25, smoothing=0.0)).predict(
        {"z": normal(2).numpy()}
    )
    assert np.allclose(action, -0.5 * normal(2).numpy(), atol=1e-6)
    assert memory["x"].dtype == torch.get_default_dtype()
