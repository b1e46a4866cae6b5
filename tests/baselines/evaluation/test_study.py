"""Studies of options, the search over gain and speed, and a comparison on a few maps (slow: `pytest -m slow`)."""

import argparse
import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from aicon_baselines.evaluation.variants import make_variants, parse_variant

import tune
from aicon_baselines.agents.registry import make
from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.evaluation.config import configure
from aicon_baselines.evaluation.rollout import rollout
from aicon_baselines.evaluation.row import Row
from aicon_baselines.evaluation.run_folder import RunFolder
from aicon_baselines.evaluation.study import bootstrap, evaluate, write_study
from aicon_baselines.evaluation.task import Episode
from aicon_baselines.tasks.nav2d import TASK
from aicon_torch import Policy

SCRIPT = Path(__file__).parent.parent / "scripts" / "study.py"
EPISODES = [Episode(seed, 0, TASK.maps[seed % len(TASK.maps)]) for seed in range(2040, 2074)]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("no_p2", ("no_p2", {})),
        ("temperature=1.0", ("aicon", {"temperature": 1.0})),
        (
            "enter_cosine=-0.42,exit_cosine=-0.28",
            ("aicon", {"enter_cosine": -0.42, "exit_cosine": -0.28}),
        ),
        (
            "no_p2, resolution=sum, temperature=None",
            ("no_p2", {"resolution": "sum", "temperature": None}),
        ),
        ("goal=(1, 2)", ("aicon", {"goal": (1, 2)})),
    ],
)
def test_variants_are_read(text: str, expected: object) -> None:
    assert parse_variant(text) == expected


@pytest.mark.parametrize("text", ["", "a,b", "margin=", "margin=2*x", "margin=0.1)+f(", "*x"])
def test_what_is_no_variant_is_refused(text: str) -> None:
    with pytest.raises(
        ComparisonError, match="a variant is written 'preset', 'option=value,option=value'"
    ):
        parse_variant(text)


def test_variants_are_built_with_their_options() -> None:
    policies = make_variants(TASK, "range", ["max_speed=0.3", "steepest,max_speed=0.4"])
    limits = {}
    for name, build in policies.items():
        policy = build("range_bearing")
        assert isinstance(policy, Policy) and "z_dir" in policy.model.sensors
        limits[name] = policy.model.actuators["a"].limit
    assert limits == {"aicon": 0.5, "max_speed=0.3": 0.3, "steepest,max_speed=0.4": 0.4}
    with pytest.raises(
        ComparisonError, match="variant 'no_such=1': 'nav2d' has no option 'no_such'. Options: "
    ):
        make_variants(TASK, "range", ["no_such=1"])
    with pytest.raises(ComparisonError, match="unknown policy 'no_such' for task 'nav2d'"):
        make_variants(TASK, "range", ["no_such"])


def rows_of(policy: str, steps: list[int | None]) -> list[Row]:
    return [
        Row(policy, "range", 0, 1000 + i, "maze", each is not None, each, False, 1.0, 1.0, 0.1)
        for i, each in enumerate(steps)
    ]


def test_differences_are_paired() -> None:
    task = replace(TASK, horizon=1000, milestones=(300,))
    rows = rows_of("aicon", [100, 200, 400, None]) + rows_of("margin=0.0", [90, 310, None, None])
    reference, variant = evaluate(rows, ["aicon", "margin=0.0"], task)
    assert (
        reference.within.success_rate,
        reference.success.success_rate,
        reference.median_steps,
    ) == (0.5, 0.75, 200)
    assert (reference.within_difference.mean, reference.steps_difference.interval) == (0, (0, 0))
    assert (variant.within.success_rate, variant.success.success_rate, variant.median_steps) == (
        0.25,
        0.5,
        200,
    )
    assert variant.within_difference.mean == -0.25
    assert variant.steps_difference.mean == np.mean([-10, 110, 600, 0])


def test_bootstrap_interval_of_a_large_sample_is_the_normal_one() -> None:
    sample = np.random.default_rng(1).normal(0.3, 2.0, 1000)
    result = bootstrap(sample)
    half = 1.96 * sample.std() / np.sqrt(1000)
    assert result.mean == pytest.approx(sample.mean())
    assert result.interval == pytest.approx((sample.mean() - half, sample.mean() + half), abs=0.02)
    assert bootstrap(sample) == result


@pytest.mark.parametrize("milestones", [(), (300,)])
def test_study_files(tmp_path: Path, milestones: tuple[int, ...]) -> None:
    task = replace(TASK, milestones=milestones)
    folder = RunFolder(tmp_path, configure(task, seed=1000, episodes=2))
    folder.append(
        rows_of("aicon", [100, 200]) + rows_of("margin=0.0", [None, None]) + rows_of("old", [1, 2])
    )
    table = write_study(task, folder, ["aicon", "margin=0.0"]).splitlines()
    assert len(table) == 4
    assert table[3].endswith(
        "| 0.0% (0.0% to 65.8%) |  | -100.0 (-100.0 to -100.0) | +11850.0 (+11800.0 to +11900.0) |"
    )
    content = json.loads((tmp_path / "study.json").read_text())
    assert [each["name"] for each in content["variants"]] == ["aicon", "margin=0.0"]
    assert content["variants"][1]["steps_difference"]["mean"] == 11850
    assert (tmp_path / "study.png").read_bytes().startswith(b"\x89PNG")


def test_script_saves_and_prints_the_results(tmp_path: Path) -> None:
    command = [sys.executable, str(SCRIPT), "--task", "nav2d", "--episodes", "2", "--horizon", "20"]
    command += ["--variants", "temperature=1.0", "--out", str(tmp_path / "new")]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    assert "| temperature=1.0 | 0.0% (0.0% to 65.8%) |" in result.stdout
    assert {path.name for path in (tmp_path / "new").iterdir()} == {
        "config.json",
        "episodes.csv",
        "study.json",
        "study.png",
    }


@pytest.mark.parametrize(
    ("task", "speeds", "seed"),
    [("nav2d", (0.25, 0.5), 1024), ("pusht", (100, 200, 400, 800), 1000)],
)
def test_tuning_searches_what_belongs_to_the_task(
    task: str, speeds: tuple[float, ...], seed: int, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    seen: list[argparse.Namespace] = []
    monkeypatch.setattr(tune, "_run", seen.append)
    command = [
        "tune.py",
        "--policies",
        "aicon",
        "--out",
        str(tmp_path),
        *(["--task", task] if task != "nav2d" else []),
    ]
    monkeypatch.setattr(sys, "argv", command)
    tune.main()
    monkeypatch.setattr(sys, "argv", [*command, "--speeds", "3"])
    tune.main()
    assert [(each.task, each.speeds, each.seed) for each in seen] == [
        (task, speeds, seed),
        (task, [3.0], seed),
    ]
    monkeypatch.setattr(sys, "argv", [*command, "--seed", "999"])
    with pytest.raises(SystemExit):
        tune.main()
    assert len(seen) == 2


@pytest.mark.slow
def test_aicon_escapes_where_the_others_stay() -> None:
    seeds = [episode.seed for episode in EPISODES]
    success = {
        name: float(rollout(make("nav2d", name), TASK, "range", EPISODES, seeds).success.mean())
        for name in ("aicon", "paper_literal", "steepest", "potential_field")
    }
    assert success["aicon"] >= 0.97
    assert (
        success["aicon"]
        > success["paper_literal"]
        > max(success["steepest"], success["potential_field"])
    )
