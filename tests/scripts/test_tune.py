"""The search over gain and speed."""

import argparse
from pathlib import Path

import pytest

import tune
from aicon_baselines.evaluation import ComparisonError
from aicon_torch import Policy
from aicon_torch.models.pusht import PIXEL, Options


def parse(*words: str) -> argparse.Namespace:
    """Parse the arguments of the script."""
    parser = argparse.ArgumentParser()
    tune.add_arguments(parser)
    return parser.parse_args(["--policies", "aicon", "--out", "runs", *words])


@pytest.mark.parametrize(
    ("task", "speeds", "seed"),
    [
        ("nav2d", (0.25, 0.5), 1024),
        ("pusht", (100 * PIXEL, 200 * PIXEL, 400 * PIXEL, 800 * PIXEL), 1000),
    ],
)
def test_it_searches_what_belongs_to_the_task(
    task: str, speeds: tuple[float, ...], seed: int
) -> None:
    usual = tune.choose_search(parse("--task", task))
    assert (usual.speeds, usual.seed) == (speeds, seed)

    asked = tune.choose_search(parse("--task", task, "--speeds", "3"))
    assert (asked.speeds, asked.gains, asked.seed) == ([3.0], usual.gains, seed)


def test_it_searches_around_what_is_shipped() -> None:
    search, shipped = tune.SEARCHES["pusht"], Options()
    assert shipped.law.gain in search.gains and shipped.max_speed in search.speeds


def test_seeds_for_reporting_are_refused() -> None:
    with pytest.raises(ComparisonError, match="--seed 999: seeds below 1000 are for reporting"):
        tune.choose_search(parse("--seed", "999"))


def test_candidates_differ_in_law_gain_and_speed() -> None:
    search = tune.Search(gains=(1.0, 2.0), speeds=(0.3,), seed=1000, episodes=1)
    candidates = tune.list_candidates("nav2d", ["aicon"], ["set", "accumulate"], search)
    assert list(candidates) == [
        "aicon set gain=1 speed=0.3",
        "aicon set gain=2 speed=0.3",
        "aicon accumulate gain=1 speed=0.3",
        "aicon accumulate gain=2 speed=0.3",
    ]

    policy = candidates["aicon accumulate gain=2 speed=0.3"]("range")
    assert isinstance(policy, Policy)
    assert policy.law.gain == 2.0 and policy.law.accumulate
    assert policy.model.actuators["a"].limit == 0.3


def test_results_are_saved_and_printed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["--gains", "10", "--speeds", "0.5", "--episodes", "1", "--out", str(tmp_path)]
    load = tune.load

    def load_short_task(name: str) -> object:
        from dataclasses import replace

        return replace(load(name), horizon=3, chunk_size=1)

    monkeypatch.setattr(tune, "load", load_short_task)
    tune.run(parse(*words))
    assert "| aicon preset gain=10 speed=0.5 | 0/1" in capsys.readouterr().out
    assert (tmp_path / "episodes.csv").exists()
