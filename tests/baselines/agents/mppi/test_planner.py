"""The planner by name, with and without the extra."""

import pickle
import sys

import pytest

pytest.importorskip("pymunk")

from aicon_baselines.agents.registry import PLANNERS, factory
from aicon_baselines.evaluation import ComparisonError
from aicon_torch import OptionError


@pytest.fixture
def no_mppi(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if "mppi" in name.split(".")[-1]]:
        monkeypatch.delitem(sys.modules, name)
    for name in [name for name in sys.modules if "agents.mppi" in name]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "pytorch_mppi", None)


@pytest.mark.usefixtures("no_mppi")
@pytest.mark.parametrize("name", PLANNERS)
def test_without_the_extra_an_error_says_how_to_get_it(name: str) -> None:
    with pytest.raises(
        ComparisonError, match=r"MPPI needs pytorch_mppi: pip install 'aicon-torch\[peers\]'"
    ):
        factory("pusht", name)
    assert callable(factory("pusht", "aicon"))  # the others do not need it


def test_it_is_no_policy_of_other_tasks() -> None:
    with pytest.raises(ComparisonError, match="unknown policy 'mppi' for task 'nav2d'"):
        factory("nav2d", "mppi")


def test_every_preset_has_a_name() -> None:
    presets = pytest.importorskip("aicon_baselines.agents.mppi.options").PRESETS
    assert tuple(presets) == PLANNERS


def test_options_override_those_of_the_preset() -> None:
    pytest.importorskip("pytorch_mppi")
    build = factory("pusht", "mppi", samples=8, horizon=2)
    assert pickle.loads(pickle.dumps(build))("object_L") is not None

    with pytest.raises(OptionError, match="MPPI has no option 'sample'"):
        factory("pusht", "mppi", sample=8)("deterministic")
    with pytest.raises(OptionError, match="samples=0: expected a whole number >= 1"):
        factory("pusht", "mppi", samples=0)("deterministic")


def test_conditions_that_it_cannot_meet_are_an_error() -> None:
    pytest.importorskip("pytorch_mppi")
    with pytest.raises(ComparisonError, match="choose other conditions"):
        factory("pusht", "mppi")("goal_jumps")
