"""The search over law and speed."""

import argparse
from pathlib import Path
from types import ModuleType

import pytest

import tune
from aicon_baselines.evaluation import ComparisonError
from aicon_torch import Policy
from aicon_torch.control import ActionLaw, DirectDescent, Foresight
from aicon_torch.models import nav2d, pusht
from aicon_torch.models.pusht import PIXEL


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
    assert (asked.speeds, asked.seed) == ([3.0], seed)
    assert (asked.steps, asked.gains) == (usual.steps, usual.gains)


@pytest.mark.parametrize(("task", "shipped"), [("nav2d", nav2d), ("pusht", pusht)])
def test_it_searches_around_what_is_shipped(task: str, shipped: ModuleType) -> None:
    search, options = tune.SEARCHES[task], shipped.Options()
    assert options.law == Foresight()
    assert options.law.step in search.steps and options.max_speed in search.speeds


def test_seeds_for_reporting_are_refused() -> None:
    with pytest.raises(ComparisonError, match="--seed 999: seeds below 1000 are for reporting"):
        tune.choose_search(parse("--seed", "999"))


def test_candidates_differ_in_law_step_gain_and_speed() -> None:
    search = tune.Search(steps=(0.5,), gains=(1.0, 2.0), speeds=(0.3,), seed=1000, episodes=1)
    laws = ["foresight", "set", "accumulate"]
    candidates = tune.list_candidates("nav2d", ["aicon"], laws, search)
    assert list(candidates) == [
        "aicon foresight step=0.5 speed=0.3",
        "aicon set gain=1 speed=0.3",
        "aicon set gain=2 speed=0.3",
        "aicon accumulate gain=1 speed=0.3",
        "aicon accumulate gain=2 speed=0.3",
    ]


@pytest.mark.parametrize(
    ("name", "law"),
    [
        ("aicon foresight step=0.5 speed=0.3", Foresight(step=0.5)),
        ("aicon set gain=2 speed=0.3", DirectDescent(gain=2.0)),
        ("aicon accumulate gain=2 speed=0.3", DirectDescent.as_in_paper(gain=2.0)),
    ],
)
def test_a_candidate_is_what_its_name_says(name: str, law: ActionLaw) -> None:
    search = tune.Search(steps=(0.5,), gains=(2.0,), speeds=(0.3,), seed=1000, episodes=1)
    candidates = tune.list_candidates("nav2d", ["aicon"], list(tune.LAWS), search)

    policy = candidates[name]("range")
    assert isinstance(policy, Policy)
    assert policy.law == law
    assert policy.model.actuators["a"].limit == 0.3


def test_results_are_saved_and_printed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words = [
        "--no-compile",
        "--steps",
        "0.5",
        "--speeds",
        "0.5",
        "--episodes",
        "1",
        "--out",
        str(tmp_path),
    ]
    load = tune.load

    def load_short_task(name: str) -> object:
        from dataclasses import replace

        return replace(load(name), horizon=3, chunk_size=1)

    monkeypatch.setattr(tune, "load", load_short_task)
    tune.run(parse(*words))
    assert "| aicon foresight step=0.5 speed=0.5 | 0/1" in capsys.readouterr().out
    assert (tmp_path / "episodes.csv").exists()
