"""Rows do not depend on how the work was spread, interrupted or divided."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from _inputs.comparison import POINTS, WALKERS, compare_walkers

from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.evaluation.comparison import compare
from aicon_baselines.evaluation.config import configure
from aicon_baselines.evaluation.progress import progress_bar
from aicon_baselines.evaluation.rows_file import read_rows
from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.evaluation.task import Measure


@pytest.fixture(scope="module")
def reference(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The file of an uninterrupted run with one job."""
    return compare_walkers(tmp_path_factory.mktemp("reference"))


def test_rows_are_all_episodes_in_order(reference: bytes, tmp_path: Path) -> None:
    (tmp_path / "episodes.csv").write_bytes(reference)
    rows = read_rows(tmp_path / "episodes.csv")

    expected = [
        (policy, "usual", repeat, seed)
        for policy in ("fast", "slow")
        for repeat in range(2)
        for seed in range(3, 19)
    ]
    assert [row[:4] for row in rows] == expected
    assert [row.map for row in rows[:4]] == ["calm", "windy", "calm", "calm"]
    assert {row.success for row in rows} == {True, False}
    assert {row.collision for row in rows} == {True, False}
    assert all((row.steps is not None) == row.success for row in rows)


def test_two_jobs_give_the_same_file(reference: bytes, tmp_path: Path) -> None:
    assert compare_walkers(tmp_path, jobs=2) == reference


@pytest.mark.slow
def test_dask_gives_the_same_file(reference: bytes, tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    assert compare_walkers(tmp_path, jobs=2, backend="dask") == reference


@pytest.mark.parametrize("share", [0.0, 0.01, 0.3, 0.7, 0.999])
def test_a_killed_run_goes_on_to_the_same_file(
    reference: bytes, tmp_path: Path, share: float
) -> None:
    compare_walkers(tmp_path)
    (tmp_path / "episodes.csv").write_bytes(reference[: int(share * len(reference))])
    assert compare_walkers(tmp_path) == reference


def test_a_finished_run_is_not_run_again(
    reference: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    compare_walkers(tmp_path)
    monkeypatch.setitem(WALKERS, "slow", lambda condition: pytest.fail("ran again"))
    assert compare_walkers(tmp_path) == reference


def test_policies_added_later_give_the_same_file(reference: bytes, tmp_path: Path) -> None:
    compare_walkers(tmp_path, policies=["slow"])
    assert compare_walkers(tmp_path, policies=["fast"]) == reference


def test_a_row_does_not_depend_on_the_range_of_seeds(reference: bytes, tmp_path: Path) -> None:
    config = configure(POINTS, seed=9, episodes=2)
    few = compare_walkers(tmp_path, config, policies=["slow"])
    assert len(few.splitlines()) == 3
    assert set(few.splitlines()) <= set(reference.splitlines())


def test_conditions_repeats_and_maps_are_as_configured(tmp_path: Path) -> None:
    conditions = ["other", "usual"]
    config = configure(
        POINTS, episodes=2, repeats=2, conditions=conditions, maps=["windy"], horizon=5
    )
    compare_walkers(tmp_path, config, policies=["slow"])
    rows = read_rows(tmp_path / "episodes.csv")

    expected = [
        (condition, repeat, seed, "windy")
        for condition in conditions
        for repeat in (0, 1)
        for seed in (0, 1)
    ]
    assert [row[1:5] for row in rows] == expected
    assert len({row.path_length for row in rows[:4]}) == 4


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"backend": "cloud"}, "valid backends: loky, dask"),
        ({"scheduler": "tcp://127.0.0.1:1"}, "belongs to the dask backend"),
        ({"jobs": 0}, "jobs must be 1 or more"),
    ],
)
def test_bad_ways_to_run_are_refused(tmp_path: Path, options: dict[str, Any], message: str) -> None:
    with pytest.raises(ComparisonError, match=message):
        compare_walkers(tmp_path, **options)


def test_rows_without_a_measure_are_refused_before_anything_runs(tmp_path: Path) -> None:
    config = configure(POINTS, episodes=2)
    newer = replace(POINTS, measures=(Measure("gap", "least gap", "{:.1f}"),))
    with RunFolder.open(tmp_path, config) as folder:
        compare(POINTS, {"fast": WALKERS["fast"]}, folder)
        before = folder.rows()
        with pytest.raises(ComparisonError, match="another version, without 'gap'"):
            compare(newer, WALKERS, folder)
        assert folder.rows() == before


def test_progress_counts_ended_episodes() -> None:
    looks: list[int] = []

    def count_ended() -> int:
        looks.append(len(looks))
        return 2

    with progress_bar(done=3, total=5, count_ended=count_ended):
        pass
    assert looks, "it looks once more at the end"
