"""Actions are differentiable by what learns, and are the actions that would be taken."""

import pytest
import torch
from _inputs.logs import AGREES, LOGS, Log, slope_off
from torch import Tensor

from aicon_torch import Policy, by_gain, by_sign, by_worth, straight_through
from aicon_torch.differentiation import is_hop, pull, stop, through_time
from aicon_torch.models.picking import Hand, build_policy

ONE_NUMBER = LOGS["nav2d"]._replace(numbers=LOGS["nav2d"].numbers[:1])
LOG = pytest.mark.parametrize(
    "log",
    [
        pytest.param(ONE_NUMBER, id="nav2d, one number"),
        *(pytest.param(log, id=n, marks=pytest.mark.slow) for n, log in LOGS.items()),
    ],
)


def drive(policy: Policy, observations: list[dict[str, Tensor]], graph: bool) -> list[Tensor]:
    """The actions of a policy on a log."""
    memory, actions = None, []
    for observation in observations:
        action, memory = policy.predict(observation, memory, create_graph=graph)
        actions.append(action)
    return actions


@LOG
def test_actions_are_the_same_with_a_graph(log: Log) -> None:
    learner, observations = log.make().learn(*log.numbers), log.observations()[:4]
    plain, differentiable = (drive(learner, observations, graph) for graph in (False, True))
    shipped = drive(log.make(), observations, False)

    for acted, same, before in zip(plain, differentiable, shipped, strict=True):
        assert torch.equal(acted, before)
        torch.testing.assert_close(acted, same.detach(), rtol=0, atol=1e-12)
        assert same.requires_grad and not acted.requires_grad


@LOG
def test_actions_have_the_gradient_of_finite_differences(log: Log) -> None:
    learner, observations = log.learner(), log.observations()[:7]
    with torch.no_grad():  # not where numbers are round, and two things are equal
        for parameter in learner.parameters():
            parameter += 0.01

    # The first bearings know far better than the prior: P − K S Kᵀ cancels, and actions round to
    # 1e-10 there, which no difference resolves.
    def what_is_done(graph: bool = False) -> Tensor:
        return torch.stack(drive(learner, observations, graph))[3:].sum(-2).flatten()

    parameters = dict(learner.named_parameters())
    done = what_is_done(graph=True)
    rows = [torch.autograd.grad(a, list(parameters.values()), retain_graph=True) for a in done]
    for (name, parameter), slopes in zip(parameters.items(), zip(*rows, strict=True), strict=True):
        wanted = torch.stack([slope.sum() for slope in slopes])
        assert wanted.abs().max() > 0, name
        assert slope_off(what_is_done, parameter, wanted) <= AGREES, name


@pytest.mark.slow
@pytest.mark.parametrize("number", ["x_tip.measurements.0.noise", "x_object.measurements.0.noise"])
def test_what_a_hand_does_has_the_gradient_of_finite_differences(number: str) -> None:
    """All that a model of picking stops is stopped in a hop only."""
    steps = (0.05, 0.05, 0.05)
    hand = Hand(time_step=0.1, steps=steps, widest=0.08, first=0.06, speed=0.3, height=0.0)
    learner = build_policy(hand).learn(number)
    block, goal = torch.tensor([0.08, 0.03, 0.02]), torch.tensor([0.2, 0.1, 0.02])
    (parameter,) = learner.parameters()

    def what_is_done(graph: bool = False) -> Tensor:
        memory, total = None, torch.zeros(())
        for step in range(8):
            tip = torch.tensor([0.05 + 0.004 * step, 0.02, 0.08 - 0.006 * step])
            seen = {"z_tip": tip, "z_block": block, "z_goal": goal}
            actions, memory = learner.predict(seen, memory, create_graph=graph)
            if step >= 2:
                total = total + actions["tip"].sum() + 0.5 * actions["jaw"].sum()
        return total

    (slope,) = torch.autograd.grad(what_is_done(graph=True), parameter)
    sides: list[Tensor] = []
    for width in (1e-4, -1e-4):
        with torch.no_grad():
            parameter += width
            sides.append(what_is_done())
            parameter -= width
    assert slope.abs() > 1e-6
    torch.testing.assert_close(slope.sum(), (sides[0] - sides[1]) / 2e-4, rtol=1e-3, atol=0)


# --- what a hop stops, a loss does not


def test_what_a_model_stops_is_stopped_in_a_hop_only() -> None:
    x = torch.tensor([2.0, 3.0], requires_grad=True)
    (acting,) = torch.autograd.grad((x * stop(x)).sum(), x)
    assert acting.tolist() == [2.0, 3.0]

    with through_time():
        value = x * stop(x)
        (of_hop,) = pull(value, x, torch.ones(2), retain_graph=True)
        (of_loss,) = torch.autograd.grad(value.sum(), x)
    assert of_hop.tolist() == [2.0, 3.0] and of_loss.tolist() == [4.0, 6.0]
    assert not is_hop()


def test_shaped_gradients_are_those_of_the_value_for_a_loss() -> None:
    x = torch.tensor([1.0, -2.0], requires_grad=True)
    with through_time():
        shaped = {
            "through": straight_through(x**2, 5 * x),
            "by sign": by_sign(3 * x, x**2),
            "by gain": by_gain(torch.eye(2) * x, x**2, 7 * x),
        }
        hop = {
            name: pull(value, x, torch.ones(2), retain_graph=True) for name, value in shaped.items()
        }
    for name, value in shaped.items():
        (slope,) = torch.autograd.grad(value.sum(), x)
        wanted = 3 * x**2 if name == "by gain" else 2 * x
        torch.testing.assert_close(slope, wanted.detach())
        assert not torch.equal(slope, hop[name][0])


def test_what_a_motion_is_worth_is_nothing_to_a_loss() -> None:
    weight, place = torch.tensor([0.5], requires_grad=True), torch.tensor([0.2, 0.0])
    with through_time():
        moved = place + by_worth(weight, place, step=0.05)
        (of_hop,) = pull(moved, weight, place, retain_graph=True)
        (of_loss,) = torch.autograd.grad(moved.square().sum(), weight)
    assert of_hop < 0 and of_loss == 0
