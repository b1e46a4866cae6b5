"""What demonstrations and diffusion policies of pushT consist of, as LeRobot calls it."""

STATE = "observation.state"
"""(2,), the pusher's position, px."""

KEYPOINTS = "observation.environment_state"
"""(16,), the object's keypoints x0, y0, x1, ..., px."""

PIXELS = "observation.image"
"""(3, height, width) in a policy, (height, width, 3) in a dataset."""

ACTION = "action"
"""(2,), target of the pusher's controller, px."""

FEATURE_TYPES = {STATE: "STATE", KEYPOINTS: "ENV", PIXELS: "VISUAL", ACTION: "ACTION"}
"""LeRobot's types of them, which choose the normalisation."""
