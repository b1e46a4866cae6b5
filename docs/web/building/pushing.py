"""The page about pushing: the T, and the policies that push it."""

from typing import Any

from aicon_envs.pusht.objects import OBJECTS
from aicon_envs.pusht.simulation import DAMPING, PUSHER_RADIUS, SIZE, STIFFNESS, SUB_STEP, SUB_STEPS
from aicon_torch.models.pusht import PIXEL
from aicon_torch.models.pusht.benchmark import GOAL_POSE
from building.packing import pack
from building.variants import variants


def data() -> dict[str, Any]:
    """What the page holds; lengths are in px."""
    policies = {name: pack(policy) for name, policy in variants("pusht", observe_goal=True)}
    return {"policies": policies, "table": table()}


def table() -> dict[str, Any]:
    """The world, as gym-pusht has it: its sizes, its pusher's controller, and the T."""
    tee = OBJECTS["T"]
    x, y, angle = GOAL_POSE
    return {
        "size": SIZE,
        "radius": PUSHER_RADIUS,
        "pixel": PIXEL,
        "stiffness": STIFFNESS,
        "damping": DAMPING,
        "sub_step": SUB_STEP,
        "sub_steps": SUB_STEPS,
        "goal": [x / PIXEL, y / PIXEL, angle],
        "keypoints": tee.keypoints.tolist(),
        "border": list(tee.border),
        "parts": [part.tolist() for part in tee.parts],
    }
