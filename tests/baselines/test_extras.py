"""The extras of the wheel."""

import re
import tomllib
from pathlib import Path

import pytest

from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.extras import (
    EXTRAS,
    extra_of,
    missing_extra,
    missing_modules,
    pip_command,
    require,
)

PYPROJECT = Path(__file__).parents[2] / "pyproject.toml"


def test_every_extra_is_one_of_the_wheel() -> None:
    project = tomllib.loads(PYPROJECT.read_text())["project"]
    declared = project["optional-dependencies"]
    for extra, modules in EXTRAS.items():
        brought = re.sub(r"[-_]", "", " ".join(declared[extra])).lower()
        missing = [module for module in modules if module.replace("_", "") not in brought]
        # dask[distributed] and lerobot[diffusion] bring a module of another name.
        assert set(missing) <= {"diffusers"}, extra


@pytest.mark.parametrize(
    ("module", "extra"),
    [
        ("matplotlib.figure", "compare"),
        ("pymunk", "pusht"),
        ("distributed", "cluster"),
        ("aicon_torch.missing", None),
        (None, None),
    ],
)
def test_a_module_names_the_extra_that_brings_it(module: str | None, extra: str | None) -> None:
    assert extra_of(module) == extra


def test_what_is_missing_has_a_command(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(EXTRAS, "cluster", ("json", "no_such_module"))
    assert missing_modules("cluster") == ("no_such_module",)
    assert pip_command("cluster") == "pip install 'aicon-torch[cluster]'"


def test_what_needs_modules_says_which_are_missing() -> None:
    require("the clock", "cluster", "json", "math")
    message = r"the clock needs no_such_one and no_such_two: pip install 'aicon-torch\[cluster\]'"
    with pytest.raises(ComparisonError, match=message):
        require("the clock", "cluster", "json", "no_such_one", "no_such_two")


def test_a_failed_import_says_what_to_install() -> None:
    error = missing_extra(ModuleNotFoundError("No module named 'joblib'", name="joblib"))
    assert str(error) == (
        "No module named 'joblib'; this needs: pip install 'aicon-torch[compare]'"
    )
    assert str(missing_extra(ModuleNotFoundError("other", name="other"))) == "other"
