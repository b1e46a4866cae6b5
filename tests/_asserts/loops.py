"""A function in C, written out and in loops."""

from collections.abc import Callable
from pathlib import Path

import torch
from _inputs import normal
from _inputs.translated import SIZE, Function, source_of, translated


def assert_loops_give_the_same_bits(
    function: Function, dtype: torch.dtype, folder: Path, begin: str, loop: Callable[[], None]
) -> None:
    """Check that a function computes the same in loops, to the last bit, and what torch does.

    Args:
        function: The function.
        dtype: Its precision.
        folder: Where libraries are written.
        begin: How such a loop begins, in C.
        loop: What lets few numbers be looped over from now on.
    """
    (folder / "loops").mkdir()
    written_out = translated(function, dtype, folder)
    loop()
    assert begin in source_of(function)
    in_loops = translated(function, dtype, folder / "loops")
    for seed in range(5):
        x = normal(SIZE, seed=seed).to(dtype)
        torch.testing.assert_close(in_loops(x), written_out(x), rtol=0, atol=0)
        torch.testing.assert_close(in_loops(x), function(x).flatten(), rtol=1e-5, atol=1e-6)
