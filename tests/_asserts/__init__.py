"""Properties that the tests check, and independent second implementations to check against."""

from _asserts.filters import BeaconStep, beacon_step, central_differences, slopes, update
from _asserts.path_gradients import along, sums_over_paths, through_jacobians
from _asserts.policies import (
    arrived,
    assert_rows_stand_alone,
    assert_same_memory,
    assert_same_steps,
    rollout,
    stacked,
)
from _asserts.resolutions import assert_orthogonal, selection
from _asserts.roundings import assert_same_but_for_roundings, unit
from _asserts.total_derivatives import assert_equal_gradients, numeric_totals, totals

__all__ = [
    "BeaconStep",
    "along",
    "arrived",
    "assert_equal_gradients",
    "assert_orthogonal",
    "assert_rows_stand_alone",
    "assert_same_but_for_roundings",
    "assert_same_memory",
    "assert_same_steps",
    "beacon_step",
    "central_differences",
    "numeric_totals",
    "rollout",
    "selection",
    "slopes",
    "stacked",
    "sums_over_paths",
    "through_jacobians",
    "totals",
    "unit",
    "update",
]
