import pytest

from aicon_torch.dampers import PlaceEscape, VelocityDampers, WayAround
from aicon_torch.errors import OptionError


def test_a_damper_without_a_way_is_refused() -> None:
    with pytest.raises(OptionError, match="braking=0: expected a positive number"):
        VelocityDampers(braking=0)
    with pytest.raises(OptionError, match="haste='2': expected 1 finite number"):
        VelocityDampers(haste="2")  # type: ignore[arg-type]


@pytest.mark.parametrize("sweeps", [0, -3, 12.5, "12", True])
def test_a_solver_makes_a_whole_number_of_sweeps(sweeps: int) -> None:
    with pytest.raises(OptionError, match=f"sweeps={sweeps!r}: expected a whole number > 0"):
        VelocityDampers(sweeps=sweeps)


def test_nothing_goes_around_faster_than_is_proposed() -> None:
    with pytest.raises(OptionError, match="haste=3.0: expected 1 with a WayAround"):
        VelocityDampers(escape=WayAround(), haste=3.0)


def test_an_escape_from_everywhere_is_refused() -> None:
    with pytest.raises(OptionError, match="near=-1.0: expected a positive number"):
        PlaceEscape(near=-1.0)
