"""A goal for a running arm: a ball comes, and the arm is told to keep off it.

What you learn: `with_estimator` and `with_goal` add to the graph of a policy that is running,
without a change to what stands there. The arm goes on from its memory, and nothing is tuned: a
safety goal bounds how fast the gap to the ball may close, and what moves by itself counts as it is
estimated to move.

A small arm of three joints holds its tip in place. After a second a ball rolls toward it. Without
the new goal it is hit; with it the arm gives way, and returns when the ball has passed.

    python examples/06_add_to_a_running_arm.py
"""

import math

import torch
from torch import Tensor

from aicon_torch import Goal, Interconnection, Policy, Sensor, make_policy
from aicon_torch.models.reach import Robot
from aicon_torch.parts import (
    Capsule,
    Capsules,
    Chain,
    Joint,
    Obstacle,
    SquaredHinge,
    moving_point,
)
from aicon_torch.policy import Memory

DT = 0.02
RADIUS = 0.05
"""Of the ball, m."""


def small_arm() -> Robot:
    """Three links of 30 cm in a plane, as capsules with a radius of 3 cm."""
    start = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0))
    link = ((1.0, 0.0, 0.0, 0.3), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0))
    joints = [Joint(f"joint_{i}", low=-2.8, high=2.8, speed=2.0) for i in range(1, 4)]
    chain = Chain([start, link, link], link, joints)

    capsules = tuple(Capsule(i, (0.0, 0.0, 0.0), (0.3, 0.0, 0.0), 0.03) for i in range(1, 4))
    return Robot(chain, Capsules(capsules, ("upper", "middle", "lower"), pairs=((0, 2),)))


def with_ball(policy: Policy, arm: Robot) -> Policy:
    """The same graph with a sensor, an estimator and a goal more."""
    assert arm.shape is not None
    obstacle = Obstacle(RADIUS, arm.shape.capsules, SquaredHinge(0.02, 1.0))
    keep_off = Interconnection(obstacle, inputs=["x_body", "x_ball"])

    ball = moving_point("x_ball", "z_ball", DT)
    seen = policy.with_estimator(ball, z_ball=Sensor(3, "m", key="ball"))
    return seen.with_goal(Goal("ball", keep_off, safety=True))


def run(adds_goal: bool) -> tuple[float, float]:
    """The least gap to the ball, and how far the tip is from its target in the end, m."""
    arm = small_arm()
    policy = make_policy("reach", robot=arm, speed=2.0, dt=DT).compile()  # the same, much faster
    q = torch.tensor([0.6, 0.8, 0.6], dtype=torch.float64)
    target = arm.chain(q)[:3, 3]
    checked = Obstacle(RADIUS, small_arm().shape.capsules, SquaredHinge(0.02, 1.0))

    memory: Memory | None = None
    least_gap = math.inf
    for step in range(round(10.0 / DT)):
        time = step * DT
        ball = target + torch.tensor([1.2 - 0.4 * time, 0.02, 0.0], dtype=torch.float64)
        observation = {"q": q, "target_position": target, "ball": ball}

        # The robot is told of the ball while it runs: what it remembers, it keeps.
        if adds_goal and time == 1.0:
            policy = with_ball(policy, arm)

        action, memory = policy.predict(observation, memory)
        q = q + DT * action
        least_gap = min(least_gap, float(checked.distances(body(arm, q), ball).min()))

    return least_gap, float((arm.chain(q)[:3, 3] - target).norm())


def body(arm: Robot, q: Tensor) -> Tensor:
    """The segments of the arm's capsules, ``(3, 6)``, m."""
    frames = arm.chain.frames(q)
    return torch.cat((frames[:3, :3, 3], frames[1:, :3, 3]), dim=-1)


def main() -> None:
    """Compare the arm that is told of the ball with one that is not."""
    without, _ = run(adds_goal=False)
    with_goal, distance = run(adds_goal=True)
    print(f"without the goal: least gap to the ball {1e3 * without:.0f} mm")
    print(f"with the goal: least gap {1e3 * with_goal:.0f} mm")
    print(f"and in the end {1e3 * distance:.1f} mm from the target")

    if not (without < 0 < with_goal and distance < 0.005):
        raise SystemExit("The new goal did not do what was announced.")
    print("The arm gave way to the ball, and came back.")


if __name__ == "__main__":
    main()
