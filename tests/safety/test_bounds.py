"""Safety goals bound the actions: nothing violates them, and they meet no gradient."""

import math

import pytest
import torch
from _inputs import normal
from _inputs.walls import DT, drive, left_of_wall, place, point_policy, wall
from torch import Tensor, nn

from aicon_torch import Actuator, Goal, GraphError, Interconnection, Sensor, WorldModel
from aicon_torch.dampers import VelocityDampers
from aicon_torch.parts import JointLimits, SquaredHinge, moving_point

STILL = VelocityDampers(escape=None)


def test_the_wall_is_never_passed_and_the_way_along_it_is_free() -> None:
    targets = place(3.0, 0.0) + 0.5 * normal(20, 2, seed=1)
    way, _ = drive(point_policy([wall()], dampers=STILL), 0.3 * normal(20, 2), targets, steps=200)
    assert way[..., 0].max() < 1.0
    torch.testing.assert_close(way[-1, :, 1], targets[:, 1], rtol=0, atol=0.05)


def test_a_cost_without_gaps_is_kept_below_its_tolerance() -> None:
    goal = Goal("wall", left_of_wall, tolerance=1.0, safety=True)
    with_gaps, _ = drive(point_policy([wall()], dampers=STILL), place(0, 0), place(3, 1), steps=80)
    with_cost, _ = drive(point_policy([goal], dampers=STILL), place(0, 0), place(3, 1), steps=80)
    torch.testing.assert_close(with_cost, with_gaps)


def test_a_safety_goal_is_no_gradient_that_another_meets() -> None:
    policy = point_policy([wall()])
    _, memory = drive(policy, place(0.9, 0.0), place(3.0, 0.0), steps=2)
    assert all(
        trace.paths == (("reach", "x", "a"),) for trace in policy.trace(memory).quantities.values()
    )


def test_a_component_without_a_stop_leaves_the_others_their_ranges() -> None:
    limits = JointLimits((-1.0, -math.inf), (1.0, math.inf), SquaredHinge(0.02, 1.0))
    stops = Goal("stops", Interconnection(limits, inputs=["x"]), safety=True)
    _, memory = drive(point_policy([stops]), place(0.5, 0.0), place(3.0, 0.0), steps=120)
    assert memory["a/escape/stops"].tolist() == [1.0, 0.0]


def test_a_safety_goal_that_is_switched_off_asks_for_nothing() -> None:
    policy = point_policy([wall()], dampers=STILL)
    _, memory = policy.predict({"z": place(0.95, 0.0), "z_target": place(3.0, 0.0)})
    off = policy.switch(memory, wall=False)

    observation = {"z": place(0.95, 0.0), "z_target": place(3.0, 0.0)}
    kept, _ = policy.predict(observation, memory)
    free, _ = policy.predict(observation, off)
    assert kept[0] < 0.2
    assert free[0] == pytest.approx(1.0)


def test_a_robot_as_many_times_as_fast_takes_the_same_way() -> None:
    ways = []
    for factor in (1.0, 2.0, 5.0):
        policy = point_policy([wall()], speed=factor, dt=DT / factor)
        ways.append(drive(policy, place(0, 0), place(3.0, 1.0), steps=60)[0])
    torch.testing.assert_close(ways[1], ways[0], rtol=0, atol=1e-6)
    torch.testing.assert_close(ways[2], ways[0], rtol=0, atol=1e-6)


def test_a_control_rate_as_many_times_as_high_takes_the_same_way() -> None:
    policies = [point_policy([wall()], dt=dt) for dt in (DT / 2, DT / 8)]
    start, target = place(0, 0), place(3.0, 1.0)
    # Until a stalemate is seen: its clock begins anew with whole steps.
    coarse, _ = drive(policies[0], start, target, steps=58)
    fine, _ = drive(policies[1], start, target, steps=232)
    torch.testing.assert_close(coarse, fine[::4], rtol=0, atol=0.02)


def test_what_comes_near_by_itself_pushes_the_robot_away() -> None:
    def distance(x: Tensor, x_ball: Tensor) -> Tensor:
        return 0.5 - (x - x_ball[..., :2]).norm(dim=-1)

    keep_off = Goal("ball", distance, safety=True)
    policy = point_policy(
        [keep_off],
        sensors={"z_ball": Sensor(3, "m")},
        estimators=[moving_point("x_ball", "z_ball", DT)],
        dampers=STILL,
    )

    x, ball, memory, nearest = place(0.0, 0.0), place(2.0, 0.1, 0.0), None, 9.0
    for _ in range(120):
        observation = {"z": x, "z_target": place(0.0, 0.0), "z_ball": ball}
        action, memory = policy.predict(observation, memory)
        x, ball = x + DT * action, ball - DT * place(0.4, 0.0, 0.0)
        nearest = min(nearest, float((x - ball[:2]).norm()))
    assert nearest > 0.49


def test_a_batch_is_as_many_singles() -> None:
    policy, starts = point_policy([wall()]), 0.5 * normal(2, 3, 2)
    targets = place(3.0, 0.0) + normal(2, 3, 2, seed=1)
    together, _ = drive(policy, starts, targets, steps=60)
    alone, _ = drive(policy, starts[1, 2], targets[1, 2], steps=60)
    torch.testing.assert_close(together[:, 1, 2], alone)


def test_the_compiled_step_keeps_them_alike() -> None:
    policy, target = point_policy([wall()]), place(3.0, 0.5).expand(2, 2)
    start = 0.5 * normal(2, 2)
    expected, _ = drive(policy, start, target, steps=40)
    found, _ = drive(policy.compile(), start, target, steps=40)
    torch.testing.assert_close(found, expected)


def test_an_actuator_without_a_limit_cannot_keep_a_safety_goal() -> None:
    policy = point_policy([wall()])
    model = policy.model
    with pytest.raises(GraphError, match="limit=inf: the safety goal 'wall' needs a finite one"):
        type(policy)(
            WorldModel(
                sensors=model.sensors,
                actuators={"a": Actuator(2, "m/s")},
                estimators=model.declaration.estimators,
                goals=list(model.goals.values()),
                dt=DT,
                dtype=torch.float64,
            ),
            law=policy.law,
        )


class Elsewhere(nn.Module):
    """A cost of the point, and gaps that no action moves."""

    def forward(self, x: Tensor, z_target: Tensor) -> Tensor:
        return x[..., 0]

    def gaps(self, x: Tensor, z_target: Tensor) -> Tensor:
        return z_target


class Constant(Elsewhere):
    def gaps(self, x: Tensor, z_target: Tensor) -> Tensor:
        return torch.ones_like(z_target)


@pytest.mark.parametrize("cost", [Elsewhere(), Constant()], ids=["elsewhere", "constant"])
def test_gaps_that_no_action_moves_are_named(cost: nn.Module) -> None:
    with pytest.raises(GraphError, match="'lost': its gaps do not depend on the actuator 'a'"):
        point_policy([Goal("lost", cost, safety=True)])
