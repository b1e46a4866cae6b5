"""Bits that say what collides with what: MuJoCo's `contype` and `conaffinity`."""

FREE = 0
"""Collides with nothing."""

ROBOT = 1
OBJECT = 2
TABLE = 4
