"""The comparison: rows do not depend on how the work is spread, and their numbers are summed up correctly."""

import json
import os
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, VectorEnv
from numpy.typing import NDArray

from aicon_baselines.agents.registry import Factory, factory, make
from aicon_baselines.evaluation import ComparisonError, names, tasks
from aicon_baselines.evaluation.comparison import compare
from aicon_baselines.evaluation.config import Config, configure
from aicon_baselines.evaluation.curves import success_curve
from aicon_baselines.evaluation.intervals import wilson_interval
from aicon_baselines.evaluation.progress import ProgressBar, report
from aicon_baselines.evaluation.report import write_report
from aicon_baselines.evaluation.rollout import rollout
from aicon_baselines.evaluation.row import Row
from aicon_baselines.evaluation.run_folder import RunFolder, read_rows
from aicon_baselines.evaluation.statistics import summarize
from aicon_baselines.evaluation.tables import list_failures, to_table
from aicon_baselines.evaluation.task import Episode, Measure, Task
from aicon_baselines.tasks import load
from aicon_envs.nav2d import MAP_NAMES, Nav2DVectorEnv, shortest_path_length

TASKS = [
    "nav2d",
    pytest.param(
        "pusht", marks=pytest.mark.skipif(find_spec("pymunk") is None, reason="needs pymunk")
    ),
]
SCRIPT = Path(__file__).parent.parent / "scripts" / "compare.py"
TARGET = np.array([3.0, 0.0])  # m
WALL = 1.5  # m; touching y = WALL is a collision


class PointEnv(VectorEnv[Any, Any, Any]):
    """Points that walk from the origin to TARGET below a wall, pushed about by noise of 0.1 m a step."""

    metadata = {"autoreset_mode": AutoresetMode.DISABLED}

    def __init__(self, num_envs: int) -> None:
        self.num_envs = num_envs

    def reset(
        self, *, seed: Any = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        self.generators = [np.random.default_rng(s) for s in seed]
        self.scale = np.array([2.0 if name == "windy" else 1.0 for name in (options or {})["map"]])[
            :, None
        ]
        self.position = np.zeros((self.num_envs, 2))
        return self._observe()

    def step(self, actions: NDArray[np.float64]) -> Any:
        noise = np.stack([generator.normal(0.0, 0.1, 2) for generator in self.generators])
        ended = self.success | self.collision
        self.position = np.where(
            ended[:, None], self.position, self.position + 0.1 * actions + self.scale * noise
        )
        observation, info = self._observe()
        return (
            observation,
            np.zeros(self.num_envs),
            self.success | self.collision,
            np.zeros(self.num_envs, bool),
            info,
        )

    def _observe(self) -> tuple[dict[str, NDArray[np.float64]], dict[str, Any]]:
        distance = np.linalg.norm(TARGET - self.position, axis=-1)
        self.collision = self.position[:, 1] > WALL
        self.success = (distance < 0.2) & ~self.collision
        info = {"is_success": self.success, "collision": self.collision, "distance": distance}
        return {"target": TARGET - self.position}, info | {"position": self.position}


class Walker:
    """Walks to the target at a speed (m/s) that grows with the number of steps it remembers."""

    def __init__(self, speed: float) -> None:
        self.speed = speed

    def predict(
        self,
        observation: dict[str, NDArray[Any]],
        state: Any = None,
        episode_start: NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Any, Any]:
        assert episode_start is not None
        age = np.where(episode_start, 0, 0 if state is None else state)
        target = observation["target"]
        direction = target / np.linalg.norm(target, axis=-1, keepdims=True)
        # The mean over the batch stands for what batched arithmetic does to the last bits, only larger.
        return self.speed * (1 + 0.01 * age[:, None]) * direction + 0.01 * target.mean(
            axis=0
        ), age + 1


def make_env(count: int, condition: str, horizon: int) -> VectorEnv[Any, Any, Any]:
    return PointEnv(count)


def reset_arguments(episodes: Sequence[Episode]) -> dict[str, Any]:
    options = {"map": [episode.map for episode in episodes]}
    return {"seed": [episode.noise_seed for episode in episodes], "options": options}


def policy_options(condition: str) -> dict[str, Any]:
    return {}


def distance_to_target(episode: Episode) -> float:
    return 2.8


TASK = Task(
    name="points",
    time_step=0.1,
    horizon=40,
    chunk_size=8,
    maps=("calm", "windy", "calm"),
    conditions=("usual", "other"),
    make_env=make_env,
    reset_arguments=reset_arguments,
    policy_options=policy_options,
    shortest_path_length=distance_to_target,
)


def slow(condition: str) -> Walker:
    return Walker(0.7)


def fast(condition: str) -> Walker:
    return Walker(2.0)


POLICIES: dict[str, Factory] = {"slow": slow, "fast": fast}


def run(
    path: Path,
    config: Config | None = None,
    policies: Sequence[str] = ("slow", "fast"),
    **options: Any,
) -> bytes:
    """Run a comparison and return its file of episodes."""
    folder = RunFolder(path, config or configure(TASK, seed=3, episodes=16, repeats=2))
    compare(TASK, {name: POLICIES[name] for name in policies}, folder, **options)
    return (path / "episodes.csv").read_bytes()


@pytest.fixture(scope="module")
def reference(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """Return the file of an uninterrupted run with one job."""
    return run(tmp_path_factory.mktemp("reference"))


def test_rows_are_all_episodes_in_order(reference: bytes, tmp_path: Path) -> None:
    (tmp_path / "episodes.csv").write_bytes(reference)
    rows = read_rows(tmp_path / "episodes.csv")
    expected = [
        (p, "usual", r, s) for p in ("fast", "slow") for r in range(2) for s in range(3, 19)
    ]
    assert [row[:4] for row in rows] == expected
    assert [row.map for row in rows[:4]] == ["calm", "windy", "calm", "calm"]
    assert {row.success for row in rows} == {True, False}
    assert {row.collision for row in rows} == {True, False}
    assert all((row.steps is not None) == row.success for row in rows)


def test_two_jobs_give_the_same_file(reference: bytes, tmp_path: Path) -> None:
    assert run(tmp_path, jobs=2) == reference


def test_dask_gives_the_same_file(reference: bytes, tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    assert run(tmp_path, jobs=2, backend="dask") == reference


@pytest.mark.parametrize("share", [0.0, 0.01, 0.3, 0.7, 0.999])
def test_a_killed_run_goes_on_to_the_same_file(
    reference: bytes, tmp_path: Path, share: float
) -> None:
    run(tmp_path)
    (tmp_path / "episodes.csv").write_bytes(reference[: int(share * len(reference))])
    assert run(tmp_path) == reference


def test_a_finished_run_is_not_run_again(
    reference: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run(tmp_path)
    monkeypatch.setitem(POLICIES, "slow", lambda condition: pytest.fail("ran again"))
    assert run(tmp_path) == reference


def test_policies_added_later_give_the_same_file(reference: bytes, tmp_path: Path) -> None:
    run(tmp_path, policies=["slow"])
    assert run(tmp_path, policies=["fast"]) == reference


def test_a_row_does_not_depend_on_the_range_of_seeds(reference: bytes, tmp_path: Path) -> None:
    few = run(tmp_path, configure(TASK, seed=9, episodes=2), policies=["slow"])
    assert len(few.splitlines()) == 3
    assert set(few.splitlines()) <= set(reference.splitlines())


def test_conditions_repeats_and_maps_are_as_configured(tmp_path: Path) -> None:
    config = configure(
        TASK, episodes=2, repeats=2, conditions=["other", "usual"], maps=["windy"], horizon=5
    )
    run(tmp_path, config, policies=["slow"])
    rows = read_rows(tmp_path / "episodes.csv")
    assert [row[1:5] for row in rows] == [
        (c, r, s, "windy") for c in ("other", "usual") for r in (0, 1) for s in (0, 1)
    ]
    assert len({row.path_length for row in rows[:4]}) == 4


def test_rollout_masks_what_has_ended() -> None:
    episodes = TASK.chunk(0, repeat=0)
    finished: list[int] = []
    outcome = rollout(Walker(2.0), TASK, "usual", episodes, range(8), finished.append)
    assert sum(finished) == 8
    assert (outcome.success ^ outcome.collision ^ (outcome.steps == TASK.horizon)).all()
    ended = outcome.steps < TASK.horizon
    assert ended.any()
    longer = rollout(Walker(2.0), replace(TASK, horizon=80), "usual", episodes, range(8))
    for short, long in zip(outcome[:-1], longer[:-1], strict=True):
        np.testing.assert_array_equal(short[ended], long[ended])


def test_progress_counts_ended_episodes() -> None:
    with ProgressBar(done=3, total=5) as bar:
        report(bar.path, 2)
        assert bar.path.stat().st_size == 2
    report(bar.path, 1)
    assert not bar.path.exists()


def test_wilson_interval_against_published_numbers() -> None:
    # Newcombe, Statistics in Medicine 17 (1998), table I, method 3.
    for successes, trials, low, high in [
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0, 0.1611),
    ]:
        assert wilson_interval(successes, trials) == pytest.approx((low, high), abs=5e-5)
    assert wilson_interval(29, 29) == pytest.approx((0.8830, 1.0), abs=5e-5)
    with pytest.raises(ValueError, match="3 of 2"):
        wilson_interval(3, 2)


def handmade() -> list[Row]:
    def row(
        policy: str, seed: int, name: str, steps: int | None, path: float, collision: bool = False
    ) -> Row:
        return Row(
            policy, "usual", 0, seed, name, steps is not None, steps, collision, path, 2.0, 0.1
        )

    return [
        row("a", 0, "u", 100, 2.0),
        row("a", 1, "v", 300, 6.0),
        row("a", 2, "u", None, 9.0, collision=True),
        row("a", 3, "v", 100, 3.0),
        row("b", 0, "u", None, 9.0),
    ]


def test_summary_of_handmade_rows() -> None:
    first, second = summarize(handmade())
    assert (first.policy, first.episodes, first.successes, first.collisions) == ("a", 4, 3, 1)
    assert (first.success_rate, first.median_steps, first.median_path_ratio) == (0.75, 100, 1.5)
    assert first.interval == wilson_interval(3, 4)
    assert (first.maps["u"].episodes, first.maps["u"].collisions, first.maps["u"].success_rate) == (
        2,
        1,
        0.5,
    )
    assert (second.policy, second.success_rate, second.median_steps, second.median_path_ratio) == (
        "b",
        0,
        None,
        None,
    )
    table = to_table([first, second], TASK).splitlines()
    assert len(table) == 4
    assert table[2].startswith("| usual | a | 3/4 = 75.0% (30.1% to 95.4%) | 1 | 10.0 s | 1.50 |")


STEPS_TASK = replace(
    TASK,
    horizon=400,
    time_unit="steps",
    length_unit="px",
    milestones=(99, 100, 300),
    shortest_path_length=None,
)


def test_summary_by_steps_of_handmade_rows() -> None:
    rows = [row._replace(shortest_path_length=None) for row in handmade()]
    assert [Row.from_fields(row.to_fields()) for row in rows] == rows
    first, second = summarize(rows, STEPS_TASK.milestones)
    assert [(each.steps, each.successes, each.success_rate) for each in first.milestones] == [
        (99, 0, 0.0),
        (100, 2, 0.5),
        (300, 3, 0.75),
    ]
    assert first.milestones[1].interval == wilson_interval(2, 4)
    assert (first.median_steps, first.percentile_95_steps, first.longest_steps) == (100, 280, 300)
    assert (second.median_steps, second.percentile_95_steps, second.longest_steps) == (
        None,
        None,
        None,
    )
    assert (first.failed_seeds, second.failed_seeds, first.median_path_ratio) == ([2], [0], None)
    table = to_table([first, second], STEPS_TASK).splitlines()
    assert table[0].endswith(
        "| within 100 steps | within 300 steps | median steps | 95th percentile | longest |"
    )
    assert table[2].endswith(
        "| 50.0% (15.0% to 85.0%) | 75.0% (30.1% to 95.4%) | 100 | 280 | 300 |"
    )
    assert table[3].endswith(" |  |  |  |")


def test_what_a_task_measures_is_in_rows_and_table() -> None:
    measures = (
        Measure("angle", "angle", "{:.0f} deg", 10.0),
        Measure("gap", "least gap", "{:.2f} px", least=True),
    )
    task = replace(STEPS_TASK, measures=measures)
    rows = [
        row._replace(measures={"angle": row.seed / 2, "gap": 3.0 - row.seed}) for row in handmade()
    ]
    assert [Row.from_fields(row.to_fields()) for row in rows] == rows
    first, second = summarize(rows, task.milestones, measures)
    assert first.measures == {"angle": 0.5, "gap": 0.0}  # the successes have seeds 0, 1 and 3
    assert second.measures == {"angle": None, "gap": 3.0}
    assert "| within 10 s |" in to_table([first], replace(task, time_unit="s"))
    table = to_table([first, second], task).splitlines()
    assert table[0].endswith("| median distance at the end | angle | least gap |")
    assert table[2].endswith("| 0.1000 px | 5 deg | 0.00 px |")
    assert table[3].endswith("|  |  | 3.00 px |")


def test_failures_are_listed_where_there_are_few() -> None:
    rows = handmade()
    many = [rows[-1]._replace(policy="c", seed=seed) for seed in range(21)]
    assert list_failures([*rows, *many], STEPS_TASK).splitlines() == [
        "usual, a: failed with seed 2 (collision)",
        "usual, b: failed with seed 0 (0.1 px left)",
    ]
    assert list_failures(rows[:2], TASK) == ""


def test_a_comparison_keeps_the_milestones_below_its_horizon() -> None:
    config = configure(STEPS_TASK, horizon=100)
    assert config.apply(STEPS_TASK).milestones == (99, 100)


def test_success_curve_of_handmade_rows() -> None:
    times, shares = success_curve(handmade()[:4], time_step=0.1)
    np.testing.assert_allclose(times, [10.0, 30.0])
    np.testing.assert_allclose(
        shares, [[0.5, *wilson_interval(2, 4)], [0.75, *wilson_interval(3, 4)]]
    )


@pytest.mark.parametrize("task", [TASK, STEPS_TASK], ids=["seconds", "steps"])
@pytest.mark.parametrize(
    "rows", [handmade(), handmade()[4:]], ids=["some succeed", "none succeeds"]
)
def test_report_files(tmp_path: Path, rows: list[Row], task: Task) -> None:
    folder = RunFolder(tmp_path, configure(task, episodes=4))
    conditions = [
        rows[0]._replace(condition=name) for name in ("w", "x", "y")
    ]  # more than one line of panels
    folder.append([*rows, *conditions])
    assert write_report(task, folder) == to_table(
        summarize([*rows, *conditions], task.milestones), task
    )
    content = json.loads((tmp_path / "summary.json").read_text())
    assert content["config"]["episodes"] == 4
    assert content["summaries"][0]["maps"]["u"]["episodes"] == sum(
        r.map == "u" and r.policy == rows[0].policy for r in rows
    )
    assert (tmp_path / "success_curve.png").read_bytes().startswith(b"\x89PNG")


def test_another_configuration_is_refused(tmp_path: Path) -> None:
    config = configure(TASK, episodes=4)
    RunFolder(tmp_path, config)
    RunFolder(tmp_path, config)
    with pytest.raises(
        ComparisonError,
        match="another comparison: episodes is 4 there and 5 here; seed is 0 there and 1",
    ):
        RunFolder(tmp_path, replace(config, episodes=5, seed=1))


def test_broken_files_are_refused(tmp_path: Path) -> None:
    folder = RunFolder(tmp_path, configure(TASK))
    folder.append(handmade())
    path = tmp_path / "episodes.csv"
    path.write_text(path.read_text().replace("300", "many"))
    with pytest.raises(ComparisonError, match="line 3 is not a row"):
        folder.rows()
    path.write_text("a,b\n1,2\n")
    with pytest.raises(ComparisonError, match="expected .'policy'"):
        folder.rows()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"episodes": 0}, "episodes must be 1 or more, not 0"),
        ({"repeats": 0}, "repeats must be 1 or more"),
        ({"horizon": 0}, "horizon must be 1 or more"),
        ({"seed": -1}, "seed must be 0 or more, not -1"),
        ({"maps": ["stormy"]}, "unknown map 'stormy'; valid maps: calm, windy$"),
        ({"conditions": ["odd"]}, "unknown condition 'odd'; valid conditions: usual, other"),
        (
            {"conditions": ["usual", "other"], "repeats": 2},
            "repeats must be 1, not 2, without noise, as in other",
        ),
    ],
)
def test_bad_configurations_say_what_would_be_right(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ComparisonError, match=message):
        configure(replace(TASK, noiseless=("other",)), **options)


def test_unknown_names_list_the_valid_ones() -> None:
    for build in (make, factory):
        with pytest.raises(
            ComparisonError,
            match="unknown policy 'oracle' for task 'nav2d'; valid policies: aicon, paper",
        ):
            build("nav2d", "oracle")
    with pytest.raises(ComparisonError, match="valid tasks: nav2d, pusht"):
        names("chess")
    with pytest.raises(ComparisonError, match="valid tasks: nav2d, pusht"):
        load("chess")


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
        run(tmp_path, **options)


def test_a_task_says_what_it_needs(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(tasks._MODULES, "pusht", "no_such_module")
    with pytest.raises(
        ComparisonError, match="'no_such_module'; the task 'pusht' needs: pip install .*pusht"
    ):
        load("pusht")


@pytest.mark.parametrize("name", TASKS)
def test_every_policy_can_be_built_and_steps(name: str) -> None:
    task = load(name)
    for condition in task.conditions[:2]:
        env = task.make_env(2, condition, 5)
        observation, _ = env.reset(**task.reset_arguments(task.chunk(0, repeat=0)[:2]))
        for policy in names(name):
            action, state = make(name, policy, condition).predict(
                observation, episode_start=np.ones(2, np.bool_)
            )
            assert action.shape == (2, 2) and np.isfinite(action).all() and state is not None
        env.close()


@pytest.mark.parametrize("name", TASKS)
def test_every_condition_can_be_run(name: str) -> None:
    task = replace(load(name), chunk_size=2, horizon=4)
    for condition in task.conditions:
        if condition == "upstream":
            pytest.importorskip("gym_pusht")
        policy = factory(name, "aicon")(condition)
        first, again = (
            rollout(policy, task, condition, task.chunk(0, repeat=0), range(2)) for _ in range(2)
        )
        assert (first.steps == 4).all() and (first.path_length > 0).all(), condition
        np.testing.assert_array_equal(first.path_length, again.path_length)
    assert set(task.noiseless) <= set(task.conditions)


@pytest.mark.parametrize("name", TASKS)
def test_a_task_leaves_ended_episodes_alone(name: str) -> None:
    task = load(name)
    env = task.make_env(2, task.conditions[0], 3)
    env.reset(**task.reset_arguments(task.chunk(0, repeat=0)[:2]))
    actions = 0.5 * np.ones((2, 2), np.float32)
    *_, truncated, info = [env.step(actions) for _ in range(3)][-1]
    assert truncated.all()
    *_, truncated, again = env.step(actions)
    assert truncated.all()
    np.testing.assert_array_equal(info["position"], again["position"])
    env.close()


@pytest.mark.parametrize("condition", ["deterministic", "noise_2", "upstream"])
def test_pusht_starts_are_those_of_gym_pusht_and_repeats_differ_in_noise(condition: str) -> None:
    gym_pusht = pytest.importorskip("gym_pusht.envs")
    task = load("pusht")
    upstream = gym_pusht.PushTEnv(obs_type="environment_state_agent_pos")
    ends = []
    for repeat in (0, 1):
        env = task.make_env(2, condition, 5)
        observation, _ = env.reset(**task.reset_arguments(task.chunk(2, repeat)[7:9]))
        for row, seed in enumerate((207, 208)):
            expected, _ = upstream.reset(seed=seed)
            for key, value in expected.items():
                np.testing.assert_allclose(observation[key][row], value, rtol=1e-12)
        ends.append(env.step(np.full((2, 2), 256, np.float32))[4]["position"])
        env.close()
    assert (ends[0] == ends[1]).all() == (condition in task.noiseless)


def test_nav2d_seeds_choose_every_class_and_mazes_twice() -> None:
    task = load("nav2d")
    counts = Counter(episode.map for episode in task.chunk(0, repeat=0)[:17])
    assert set(counts) == set(MAP_NAMES)
    assert [name for name, count in counts.items() if count > 1] == ["maze"]
    first, again = task.chunk(2, repeat=0)[5], task.chunk(2, repeat=1)[5]
    assert (first.seed, first.map) == (again.seed, again.map) == (261, task.maps[261 % 17])
    assert first.noise_seed != again.noise_seed


def test_nav2d_shortest_paths_are_those_of_the_environment() -> None:
    task = load("nav2d")
    episodes = task.chunk(0, repeat=0)[:17]
    env = task.make_env(len(episodes), "range", 5)
    assert isinstance(env, Nav2DVectorEnv)
    env.reset(**task.reset_arguments(episodes))
    for episode, (name, obstacles, start, target) in zip(episodes, env.maps, strict=True):
        assert name == episode.map
        assert task.shortest_path_length(episode) == shortest_path_length(
            obstacles, start, target, env.physics.radius
        )


class TowardBearing:
    """Walks toward the target at 0.5 m/s."""

    def predict(
        self,
        observation: dict[str, NDArray[Any]],
        state: Any = None,
        episode_start: NDArray[np.bool_] | None = None,
        deterministic: bool = True,
    ) -> tuple[Any, Any]:
        bearing = observation["bearing"]
        return 0.5 * np.concatenate([np.cos(bearing), np.sin(bearing)], axis=-1), None


def test_nav2d_walking_straight_at_the_target(tmp_path: Path) -> None:
    task = replace(load("nav2d"), chunk_size=16)
    folder = RunFolder(
        tmp_path, configure(task, episodes=8, maps=["ring_outside", "clutter"], horizon=800)
    )
    compare(task, {"straight": lambda condition: TowardBearing()}, folder)
    rows = folder.rows()
    assert all(row.success or row.collision for row in rows)
    assert any(row.collision for row in rows)
    for row in rows:
        assert row.distance < 0.2 or row.collision
        assert not row.success or row.path_length > row.shortest_path_length - 0.2


def test_a_policy_can_be_compared_compiled(tmp_path: Path) -> None:
    """The robot must not notice; in a millionth of a metre after ten steps neither does the row."""
    if not shutil.which(os.environ.get("CXX", "g++")):
        pytest.skip("there is no C++ compiler")
    options = ("--policies", "aicon", "--episodes", "1", "--horizon", "10", "--out", str(tmp_path))
    for more in ((), ("--compile",)):
        result = script(*options, *more)
        assert result.returncode == 0, result.stderr
    uncompiled, compiled = sorted(read_rows(tmp_path / "episodes.csv"), key=lambda row: row.policy)
    assert (uncompiled.policy, compiled.policy) == ("aicon", "aicon_compiled")
    assert compiled.distance == pytest.approx(uncompiled.distance, abs=1e-6)


def script(*arguments: str, task: str = "nav2d") -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(SCRIPT), "--task", task, *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("task", TASKS)
def test_script_saves_and_prints_the_results(tmp_path: Path, task: str) -> None:
    options = (
        "--policies",
        "aicon",
        "steepest",
        "--episodes",
        "2",
        "--horizon",
        "10",
        "--out",
        str(tmp_path),
    )
    result = script(*options, task=task)
    assert result.returncode == 0, result.stderr
    assert f"| {load(task).conditions[0]} | aicon | 0/2 = 0.0% (0.0% to 65.8%) |" in result.stdout
    assert ", aicon: failed with seed 0 (" in result.stdout
    assert {path.name for path in tmp_path.iterdir()} == {
        "config.json",
        "episodes.csv",
        "success_curve.png",
        "summary.json",
    }


def test_script_says_what_is_wrong(tmp_path: Path) -> None:
    result = script("--policies", "oracle", "--out", str(tmp_path / "new"))
    assert result.returncode == 2
    assert "unknown policy 'oracle' for task 'nav2d'; valid policies: aicon, " in result.stderr
    assert not (tmp_path / "new").exists()


@pytest.mark.parametrize("backend", ["loky", "dask"])
def test_the_script_gives_the_same_rows_on_every_backend(backend: str, tmp_path: Path) -> None:
    """The real task, from the command line, with workers that import everything themselves."""
    if backend == "dask":
        pytest.importorskip("distributed")
    script = Path(__file__).parent.parent / "scripts" / "compare.py"
    command = [
        sys.executable,
        str(script),
        "--task",
        "nav2d",
        "--policies",
        "aicon",
        "--episodes",
        "2",
    ]
    command += ["--seed", "1024", "--horizon", "30", "--jobs", "2"]
    for name, more in (("one", ["--jobs", "1"]), ("other", ["--backend", backend])):
        subprocess.run(
            [*command, *more, "--out", str(tmp_path / name)], check=True, capture_output=True
        )
    assert (tmp_path / "one" / "episodes.csv").read_bytes() == (
        tmp_path / "other" / "episodes.csv"
    ).read_bytes()
