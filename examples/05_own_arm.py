"""An arm of one's own: from a URDF to a reactive arm.

What you learn: the description of a robot is all that the model "reach" needs. Its joints, their
limits and speeds come from the URDF, its shape from the collision geometry there. The arm goes to
wherever the target is now, keeps away from its stops and from itself whatever it wishes, and finds
its way out where they hold it up.

A LeRobot SO-101, whose five joints reach a position and an approach direction, goes to three
targets one after the other; each appears before the arm has come to rest. The robot's files come
with `pip install "aicon-torch[reach]"`.

    python examples/05_own_arm.py
"""

import torch

from aicon_envs.reach import ROBOTS, find_file
from aicon_torch import make_policy
from aicon_torch.models.reach import Robot

DT, SECONDS = 0.02, 8.0
POSITION_TOLERANCE, ANGLE_TOLERANCE = 0.01, 0.05


def main() -> None:
    """Reach three targets."""
    arm = Robot.from_urdf(find_file(ROBOTS["so101"].urdf), tip="gripper_frame_link")
    policy = make_policy("reach", robot=arm, orientation="axis", speed=2.0, dt=DT)

    # Targets that can be reached: where the tip is in some posture within the limits.
    low, high = arm.chain.low, arm.chain.high
    generator = torch.Generator().manual_seed(4)
    shares = 0.3 + 0.4 * torch.rand(3, len(low), generator=generator, dtype=torch.float64)
    targets = arm.chain(low + shares * (high - low))

    q, memory = (low + high) / 2, None
    for number, target in enumerate(targets, start=1):
        position, approach = target[:3, 3], target[:3, 2]
        observation = {"target_position": position, "target_orientation": approach}

        for step in range(round(SECONDS / DT)):
            action, memory = policy.predict({"q": q, **observation}, memory)
            q = q + DT * action  # your robot: send the velocities, read the joints
            if not ((q > low) & (q < high)).all():
                raise SystemExit("A joint is beyond its stop.")

            tip = arm.chain(q)
            distance = (tip[:3, 3] - position).norm()
            angle = torch.acos((tip[:3, 2] @ approach).clamp(-1, 1))
            if distance < POSITION_TOLERANCE and angle < ANGLE_TOLERANCE:
                print(f"target {number}: there after {(step + 1) * DT:.1f} s")
                break
        else:
            raise SystemExit(f"Target {number} was not reached.")

    print("The arm reached every target, within its limits.")


if __name__ == "__main__":
    main()
