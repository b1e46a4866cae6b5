import pytest

from aicon_torch.dampers import ConstraintEscape, VelocityDampers
from aicon_torch.errors import OptionError


@pytest.mark.parametrize("name", ["braking", "gaps", "sweeps"])
def test_a_damper_without_a_way_gaps_or_sweeps_is_refused(name: str) -> None:
    with pytest.raises(OptionError, match=f"{name}=0: expected a number > 0"):
        VelocityDampers(**{name: 0})


@pytest.mark.parametrize("name", ["progress", "patience", "shortest", "longest"])
def test_an_escape_without_time_is_refused(name: str) -> None:
    with pytest.raises(OptionError, match=f"{name}=-1.0: expected a number > 0"):
        ConstraintEscape(**{name: -1.0})
