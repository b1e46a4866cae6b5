"""The benchmark pushT in SI: its world, its pusher and its object.

The environment is a picture, with y pointing down and px as its unit. Its board of 512 px is taken
for half a metre.
"""

import math

PIXEL = 0.5 / 512
"""Size of a px, m: about a millimetre, and a power of two, so that a change of unit rounds nothing.

Everything below depends on it, and nothing else knows of px.
"""

WORKSPACE = (0.0, 512 * PIXEL)
"""Lowest and highest coordinate of a position target, m."""

SUBSTEP = 0.01
"""Time step of the PD controller that moves the pusher, s."""

PUSHER_RADIUS = 15 * PIXEL
"""Radius of the pusher, m."""

PUSHER_NOISE = 0.1 * PIXEL
"""Standard deviation of each coordinate of the pusher's position as it is read, m."""

PROCESS_NOISE = 0.5 * PIXEL
"""Standard deviation of each coordinate of what moves pusher and object in a step besides the
model, m."""

PRIOR_DEVIATION = 10 * PIXEL
"""Standard deviation of what is believed of a position at the first reading, m."""

GOAL_POSE = (256 * PIXEL, 256 * PIXEL, math.pi / 4)
"""Target of the object's body frame (x, y, θ), m and rad."""

T_WIDTH = 120 * PIXEL
"""Width of the T, m: the reference length of the contact model."""

T_KEYPOINTS = tuple(
    (x * PIXEL, y * PIXEL)
    for x, y in (
        # The bar, and then the stem, px.
        *((-60, 0), (60, 0), (60, 30), (-60, 30)),
        *((-15, 30), (15, 30), (15, 120), (-15, 120)),
    )
)
"""Corners of the T in its body frame, in the order in which the environment reports them, m."""

T_OUTLINE_ORDER = (0, 1, 2, 5, 6, 7, 4, 3)
"""The order in which they follow each other around the T."""

T_CENTER_OF_MASS = (0.0, 45 * PIXEL)
"""The T's centre of mass in the environment's physics, m."""

T_RADIUS_OF_GYRATION = 3000**0.5 * PIXEL
"""The T's radius of gyration there, m: both its boxes have the inertia of the bar.

A T of uniform density has its centre of mass at (0, 40.7) px and a radius of gyration of 43.9 px.
"""
