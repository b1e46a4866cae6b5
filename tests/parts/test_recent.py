from typing import Any

import pytest
import torch
from _inputs import normal

from aicon_torch.errors import OptionError
from aicon_torch.parts.recent import Recent


def test_it_holds_what_was_read_in_the_last_steps_oldest_first() -> None:
    recent, readings = Recent("z", steps=3), normal(6, 4, 2)
    kept = recent.initial({"z": readings[0]})
    assert torch.equal(kept["z_recent"], readings[[0, 0, 0]].transpose(0, 1).reshape(4, 6))
    for reading in readings[1:]:
        kept = recent.update({**kept, "z": reading})
    assert torch.equal(kept["z_recent"], readings[3:].transpose(0, 1).reshape(4, 6))


def test_no_gradient_goes_through_it() -> None:
    recent, kept = Recent("z", steps=2), normal(4).requires_grad_()
    assert not recent({"z_recent": kept}, "z_recent").requires_grad


@pytest.mark.parametrize("steps", [0, -1, 1.5, True, "2"])
def test_it_keeps_a_step_or_more(steps: Any) -> None:
    with pytest.raises(OptionError, match="steps=.*expected a number of steps >= 1"):
        Recent("z", steps)
