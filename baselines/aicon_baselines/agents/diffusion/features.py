"""The names of what pushT's demonstrations and diffusion policies consist of, as LeRobot calls it."""

STATE, KEYPOINTS, PIXELS, ACTION = (
    "observation.state",  # (2,), the pusher's position, px
    "observation.environment_state",  # (16,), the object's keypoints x0, y0, x1, ..., px
    "observation.image",  # (3, height, width) in a policy, (height, width, 3) in a dataset
    "action",  # (2,), target of the pusher's controller, px
)

TYPES = {STATE: "STATE", KEYPOINTS: "ENV", PIXELS: "VISUAL", ACTION: "ACTION"}
"""LeRobot's types of them, which choose the normalisation."""
