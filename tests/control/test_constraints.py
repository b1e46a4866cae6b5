"""Constraints on what a policy does."""

import numpy as np
import torch
from _asserts import assert_rows_stand_alone, assert_same_memory
from _inputs import off_the_wall, rightward, slower, steered, walled, where_to
from torch import Tensor

from aicon_torch import (
    Actuator,
    Deterministic,
    DirectDescent,
    Goal,
    Policy,
    Sensor,
    Sum,
    WorldModel,
)


def test_constraints_act_one_after_the_other() -> None:
    (reading,) = walled(1)
    free, _ = steered().predict(reading)
    right = torch.tensor([1.0, 0.0], dtype=torch.float64)

    halved, _ = steered([slower]).predict(reading)
    assert torch.equal(halved, 0.5 * free)

    halved_first, _ = steered([slower, rightward]).predict(reading)
    torch.testing.assert_close(halved_first, 0.5 * free + right)

    shifted_first, _ = steered([rightward, slower]).predict(reading)
    torch.testing.assert_close(shifted_first, 0.5 * (free + right))


def test_a_constraint_reads_what_the_step_has_estimated() -> None:
    """The estimate after this reading, and the reading of a sensor that no estimator reads."""
    policy = steered([off_the_wall])
    memory, active = None, []

    for reading in walled(30):
        action, memory = policy.predict(reading, memory)

        room = (reading["wall"] - memory["x"][:1]) / 0.1
        assert action[:1] <= room
        active.append(bool(action[:1] == room))

    assert 0 < sum(active) < len(active)


def test_the_next_step_starts_from_the_constrained_action() -> None:
    """The low-pass smooths what was done, and the prediction moves by it."""
    policy = steered([slower])
    first, second = walled(2)
    _, memory = policy.predict(first)

    done, after = policy.predict(second, memory)
    unconstrained, _ = steered().predict(second, memory)
    torch.testing.assert_close(done, 0.5 * unconstrained)

    _, faked = policy.predict(second, memory | {"a": 2.0 * memory["a"]})
    assert not torch.allclose(faked["x"], after["x"])


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

    expected = plain.estimate(recorded[1], plain.estimate(recorded[0]), executed)
    watched = limited.estimate(recorded[1], limited.estimate(recorded[0]), executed)
    del watched["a.sent"]  # where there is a command, it is remembered
    assert_same_memory(watched, expected, 0.0)

    _, memory = limited.predict(recorded[0])
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

    policy = Policy(model, Sum(), DirectDescent(1.0, smoothing=0.0))
    action, memory = policy.predict({"z": np.zeros(2)})

    assert memory["a"].tolist() == [1.0, 1.0]
    assert memory["b"].tolist() == [-0.5, -0.5]
    assert action["a"].tolist() == [1.0, 1.0]
    assert action["b"].tolist() == [-5.0, -5.0]


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

    buffers = dict(steered([Shifted()]).named_buffers())
    shifts = [buffer for name, buffer in buffers.items() if name.endswith("shift")]
    assert [shift.dtype for shift in shifts] == [torch.float64]


def test_a_reading_that_requires_a_gradient_leaves_no_graph_in_the_memory() -> None:
    reading = {name: value.requires_grad_() for name, value in walled(1)[0].items()}
    for policy in (steered(), steered([off_the_wall])):
        _, memory = policy.predict(reading)
        assert not [name for name, value in memory.items() if value.requires_grad]
