"""Constraints on what a policy does."""

import numpy as np
import torch
from _asserts import assert_rows_stand_alone, assert_same_memory
from _inputs import off_the_wall, rightward, slower, steered, walled, where_to
from torch import Tensor

from aicon_torch import ActionLaw, Actuator, Deterministic, Goal, Policy, Sensor, Sum, WorldModel


def test_constraints_act_one_after_the_other() -> None:
    (reading,) = walled(1)
    free = steered().predict(reading)[0]

    assert torch.equal(steered([slower]).predict(reading)[0], 0.5 * free)

    one, other = (
        steered(pair).predict(reading)[0] for pair in ([slower, rightward], [rightward, slower])
    )
    right = torch.tensor([1.0, 0.0], dtype=torch.float64)

    torch.testing.assert_close(one, 0.5 * free + right)
    torch.testing.assert_close(other, 0.5 * (free + right))


def test_a_constraint_reads_what_the_step_has_estimated() -> None:
    """The estimate after this reading, not the last one, and a sensor's reading that no estimator
    reads.
    """
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
    done, _ = policy.predict(second, memory)
    wish = steered().predict(second, memory)[0]  # without constraint from the same memory

    torch.testing.assert_close(done, 0.5 * wish)

    faked = policy.predict(second, memory | {"a": 2.0 * memory["a"]})[1]
    assert not torch.allclose(faked["x"], policy.predict(second, memory)[1]["x"])


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

    watched = [
        policy.estimate(recorded[1], policy.estimate(recorded[0]), executed)
        for policy in (plain, limited)
    ]
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
    assert [buffer.dtype for name, buffer in policy.named_buffers() if name.endswith("shift")] == [
        torch.float64
    ]


def test_a_reading_that_requires_a_gradient_leaves_no_graph_in_the_memory() -> None:
    reading = {name: value.requires_grad_() for name, value in walled(1)[0].items()}
    for policy in (steered(), steered([off_the_wall])):
        _, memory = policy.predict(reading)
        assert not [name for name, value in memory.items() if value.requires_grad]
