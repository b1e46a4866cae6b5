"""What the tests of all environments share."""

from typing import Any

import numpy as np


def assert_same(first: Any, second: Any, tolerance: float = 0.0) -> None:
    """Observations, infos and other results agree; without a tolerance, number for number."""
    if isinstance(first, dict):
        assert first.keys() == second.keys()
        for key in first:
            assert_same(first[key], second[key], tolerance)
    elif tolerance == 0.0:
        np.testing.assert_array_equal(first, second)
    else:
        np.testing.assert_allclose(first, second, rtol=0.0, atol=tolerance)


def assert_same_records(first: list[Any], second: list[Any]) -> None:
    """All results of two episodes agree, number for number."""
    for one, other in zip(first, second, strict=True):
        assert_same(one, other)
