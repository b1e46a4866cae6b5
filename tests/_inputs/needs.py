"""What some tests need that a machine may lack."""

from importlib.util import find_spec

import pytest

NEEDS_PYMUNK = pytest.mark.skipif(find_spec("pymunk") is None, reason="needs pymunk")
