"""Agents of stable-baselines3 in our comparison, and our pushT policy in stable-baselines3's loop."""

import json
import re
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch

import aicon_envs  # noqa: F401  (registers the environments)
import compare
import train_sb3
from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.agents.registry import factory, import_sb3, saved_agent
from aicon_baselines.evaluation.run_folder import read_rows
from aicon_baselines.tasks import load
from aicon_torch import make_policy

pytest.importorskip("stable_baselines3")
pytest.importorskip("pymunk")

from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.vec_env import DummyVecEnv

from aicon_baselines import sb3
from aicon_baselines.agents.sb3.environments import make_training_env
from aicon_baselines.agents.sb3.files import load_algorithm, load_statistics
from aicon_baselines.agents.sb3.from_pusher import OFFSETS, to_target
from aicon_baselines.agents.sb3.last_action import LAST_ACTION
from aicon_baselines.agents.sb3.shaping import ShapedPush

SMALL = {"envs": 2, "rollout": 64, "horizon": 40}
KINDS = [("nav2d", "ppo"), ("nav2d", "sac"), ("pusht", "ppo"), ("pusht", "sac")]


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, str], Path]:
    root = tmp_path_factory.mktemp("agents")
    folders = {kind: root / "_".join(kind) for kind in KINDS}
    for (task, algorithm), folder in folders.items():
        sb3.train(sb3.settings(task, algorithm, 256 if algorithm == "ppo" else 60, **SMALL), folder, checkpoint=100)
    return folders


@pytest.fixture
def call(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Calls a script's `main` with these arguments, without the seconds that a new interpreter takes."""

    def run(main: Callable[[], None], *arguments: object) -> None:
        monkeypatch.setattr(sys, "argv", ["script", *map(str, arguments)])
        main()

    return run


# --- our policy in stable-baselines3


def pushing() -> gym.Env[Any, Any]:
    return gym.make("aicon/PushT-v0", max_episode_steps=1000)


@pytest.mark.parametrize("count", [1, 2], ids=["plain", "DummyVecEnv"])
def test_evaluate_policy_runs_pusht(count: int) -> None:
    env: Any = pushing() if count == 1 else DummyVecEnv([pushing] * count)
    env.reset(seed=1000) if count == 1 else env.seed(1000)
    ends: list[bool] = []

    def record(local: dict[str, Any], _: dict[str, Any]) -> None:
        if local["done"]:
            ends.append(local["info"]["is_success"])

    rewards, lengths = evaluate_policy(
        make_policy("pusht"), env, 2, callback=record, return_episode_rewards=True, warn=False
    )
    assert ends == [True, True]
    assert all(length < 1000 for length in lengths)
    assert all(0.0 < reward <= length for reward, length in zip(rewards, lengths, strict=True))


# --- training


def test_a_shaped_episode_is_worth_the_difference_of_its_ends() -> None:
    env = ShapedPush(gym.make("aicon/PushT-v0"), approach=0.5)

    def potential(observation: dict[str, Any], info: dict[str, Any]) -> float:
        corners = observation["environment_state"].reshape(-1, 2)
        return -info["pose_error"] - 0.5 * min(np.hypot(*(corner - observation["agent_pos"])) for corner in corners)

    policy, memory, total, done = make_policy("pusht"), None, 0.0, False
    observation, info = env.reset(seed=1000)
    start = potential(observation, info)
    while not done:
        action, memory = policy.predict(observation, memory)
        observation, reward, terminated, truncated, info = env.step(action)
        total += reward
        done = terminated or truncated
    assert info["is_success"]
    assert total == pytest.approx((potential(observation, info) - start) / 100.0 + 5.0)


@pytest.mark.parametrize(("task", "algorithm"), KINDS)
def test_training_goes_on_where_it_was_saved(
    task: str, algorithm: str, folders: dict[tuple[str, str], Path], tmp_path: Path
) -> None:
    folder = shutil.copytree(folders[task, algorithm], tmp_path / "agent")
    before = json.loads((folder / "config.json").read_text())["steps"]
    lines: list[str] = []
    config = sb3.settings(task, algorithm, before + 20, **SMALL)
    after = sb3.train(config, folder, checkpoint=10, report=lines.append).steps
    assert before < before + 20 <= after == json.loads((folder / "config.json").read_text())["steps"]
    assert lines and (folder / f"log_{before}" / "progress.csv").exists()
    assert not list(folder.glob("new_*"))
    resumed = load_algorithm(folder, config)
    assert resumed.num_timesteps == after
    assert sb3.train(config, folder).steps == after  # nothing is missing
    with pytest.raises(ComparisonError, match=r"another agent: seed is 10000 there and 10001 here"):
        sb3.train(sb3.settings(task, algorithm, after, seed=10_001, **SMALL), folder)


def test_sac_learns_from_what_it_saw(folders: dict[tuple[str, str], Path]) -> None:
    """Each reading of the buffer is a stack of successive ones, and the next observation is one reading newer."""
    model: Any = load_algorithm(folders["nav2d", "sac"], sb3.settings("nav2d", "sac", 60, **SMALL))
    model.load_replay_buffer(str(folders["nav2d", "sac"] / "replay_buffer.pkl"))
    buffer = model.replay_buffer
    count = buffer.size()
    for name, width in {"range": 1, "bearing": 1, LAST_ACTION: 2}.items():
        before, after = (each[name][:count] for each in (buffer.observations, buffer.next_observations))
        assert np.array_equal(after[..., :-width], before[..., width:])
        assert len(np.unique(after[10])) == after[10].size
    assert np.array_equal(buffer.next_observations[LAST_ACTION][:count, :, -2:], buffer.actions[:count])


# --- in a comparison


@pytest.mark.parametrize(("task", "algorithm"), KINDS)
def test_an_agent_gets_in_a_comparison_what_it_got_in_training(
    task: str, algorithm: str, folders: dict[tuple[str, str], Path]
) -> None:
    """Actions and readings through VecNormalize, VecFrameStack and the wrappers, over ends of episodes."""
    folder = folders[task, algorithm]
    agent = sb3.Agent(folder, task)
    config = agent.settings
    envs = make_training_env(config, 5000)
    trained = load_statistics(folder, envs)
    trained.training = False
    model = load_algorithm(folder, config)
    seen = trained.reset()
    memory: Any = None
    start = np.ones(2, np.bool_)
    for _ in range(config.horizon + 15):
        offered: Any = envs.unwrapped.buf_obs
        readings = {name: offered[name].copy() for name in offered if name not in (LAST_ACTION, OFFSETS)}
        expected, _ = model.predict(seen, deterministic=True)
        action, memory = agent.predict(readings, memory, start)
        command = expected if config.reach is None else to_target(expected, readings, config.reach)
        assert np.allclose(action, command, atol=1e-5 * np.abs(action).max())
        seen, _, start, _ = trained.step(expected)


def test_a_missing_reading_keeps_its_last_value(folders: dict[tuple[str, str], Path]) -> None:
    agent = sb3.Agent(folders["pusht", "ppo"], "pusht")
    rng = np.random.default_rng(0)
    whole = {"environment_state": rng.uniform(0, 512, (3, 16)), "agent_pos": rng.uniform(0, 512, (3, 2))}
    missing = whole | {"environment_state": np.where(np.arange(16) < 4, np.nan, whole["environment_state"])}
    _, memory = agent.predict(whole)
    expected, _ = agent.predict(whole, memory, np.zeros(3, np.bool_))
    action, _ = agent.predict(missing, memory, np.zeros(3, np.bool_))
    assert np.array_equal(action, expected)
    alone, _ = agent.predict(missing)
    assert np.isfinite(alone).all()


def test_sampled_actions_come_from_the_memory_alone(folders: dict[tuple[str, str], Path]) -> None:
    folder = folders["pusht", "ppo"]
    likely, sampled = sb3.Agent(folder, "pusht"), sb3.Agent(folder, "pusht", sampled=True)
    rng = np.random.default_rng(0)
    readings = {"environment_state": rng.uniform(0, 512, (3, 16)), "agent_pos": rng.uniform(0, 512, (3, 2))}

    def three_steps(agent: sb3.Agent) -> list[Any]:
        memory, actions = None, []
        for _ in range(3):
            torch.rand(5)  # others draw numbers too
            action, memory = agent.predict(readings, memory, np.zeros(3, np.bool_))
            actions.append(action)
        return actions

    torch.manual_seed(1)
    first, kept = three_steps(sampled), torch.rand(1)
    torch.manual_seed(1)
    assert np.array_equal(three_steps(sampled), first)
    assert torch.equal(torch.rand(1), kept)
    assert not np.isclose(three_steps(likely), first).all(axis=(1, 2)).any()
    assert sampled.name == f"{likely.name}_sampled"


def test_rows_are_appended_to_the_same_run(
    folders: dict[tuple[str, str], Path], tmp_path: Path, call: Callable[..., None]
) -> None:
    def run(*arguments: object) -> list[Any]:
        call(compare.main, "--task", "pusht", "--episodes", 2, "--horizon", 20, "--out", tmp_path, *arguments)
        return read_rows(tmp_path / "episodes.csv")

    before = run("--policies", "steepest")
    after = run("--policies", "sb3", "--sb3-path", folders["pusht", "ppo"], folders["pusht", "sac"])
    assert [row for row in after if row.policy == "steepest"] == before
    agents = {row.policy for row in after} - {"steepest"}
    assert len(agents) == 2 and all(re.fullmatch(r"(ppo|sac)_\d+_[0-9a-f]{4}", name) for name in agents)
    for name in agents:
        assert [row.seed for row in after if row.policy == name] == [row.seed for row in before]


def test_the_comparison_takes_what_the_script_trained(
    tmp_path: Path, call: Callable[..., None], capsys: pytest.CaptureFixture[str]
) -> None:
    """The command that the training prints at its end, with fewer episodes."""
    small = [text for name, value in SMALL.items() for text in (f"--{name}", value)]
    call(train_sb3.main, "--task", "nav2d", "--steps", 128, "--out", tmp_path / "agent", *small)
    printed = capsys.readouterr().out.split("scripts/compare.py")[1].split("--out")[0].split()
    call(compare.main, *printed, "--episodes", 2, "--horizon", 5, "--out", tmp_path / "run")
    assert len(read_rows(tmp_path / "run" / "episodes.csv")) == 4


# --- bad input


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda folder: shutil.rmtree(folder), "has no config.json; save an agent there: python scripts/train_sb3.py"),
        (lambda folder: (folder / "agent.zip").unlink(), "has no agent.zip; copy the whole folder"),
        (lambda folder: (folder / "vecnormalize.pkl").unlink(), "has no vecnormalize.pkl; copy the whole folder"),
        (lambda folder: (folder / "config.json").write_text("{}"), "config.json does not describe an agent"),
        (lambda folder: (folder / "agent.zip").write_text("no zip"), "agent.zip is not an agent of PPO"),
        (lambda folder: (folder / "vecnormalize.pkl").write_bytes(b"x"), "vecnormalize.pkl holds no VecNormalize"),
        (lambda folder: edit(folder, algorithm="dqn"), "config.json: unknown algorithm 'dqn'; valid algorithms: ppo"),
        (lambda folder: edit(folder, algorithm="sac"), "agent.zip is not an agent of SAC"),
        (
            lambda folder: edit(folder, task="nav2d"),
            "was trained for 'nav2d', not 'pusht'. Compare it with --task nav2d",
        ),
    ],
)
def test_a_folder_that_is_no_agent_is_an_error(
    change: Any, message: str, folders: dict[tuple[str, str], Path], tmp_path: Path
) -> None:
    folder = shutil.copytree(folders["pusht", "ppo"], tmp_path / "agent")
    change(folder)
    with pytest.raises(ComparisonError, match=re.escape(message)):
        saved_agent("pusht", folder)


def edit(folder: Path, **values: Any) -> None:
    path = folder / "config.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | values))


def test_other_readings_are_an_error(folders: dict[tuple[str, str], Path]) -> None:
    _, build = saved_agent("pusht", folders["pusht", "ppo"])
    env = load("pusht").make_env(2, "object_L", 5)
    observation, _ = env.reset(seed=1000)
    with pytest.raises(ComparisonError, match="observes .* and this condition offers .*choose conditions"):
        build("object_L").predict(observation)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"task": "pushx"}, "unknown task 'pushx'; valid tasks: nav2d, pusht"),
        ({"algorithm": "dqn"}, "unknown algorithm 'dqn'; valid algorithms: ppo, sac"),
        ({"steps": 0}, "steps must be 1 or more, not 0"),
        ({"seed": 3}, "the seed must be 1000 or more, not 3"),
    ],
)
def test_a_training_that_makes_no_sense_is_an_error(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ComparisonError, match=re.escape(message)):
        sb3.settings(**{"task": "pusht", "algorithm": "ppo", "steps": 10} | arguments)


@pytest.mark.parametrize("arguments", [("sb3",), ("aicon", "--sb3-path", "agent")])
def test_sb3_and_its_path_belong_together(
    arguments: tuple[str, ...], tmp_path: Path, call: Callable[..., None], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        call(compare.main, "--task", "nav2d", "--out", tmp_path, "--policies", *arguments)
    assert "python scripts/train_sb3.py --task nav2d" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_missing_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.startswith("aicon_baselines.agents.sb3")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "stable_baselines3", None)
    with pytest.raises(ComparisonError, match=r"pip install 'aicon-torch\[sb3\]'"):
        import_sb3()
    assert callable(factory("nav2d", "aicon"))  # the others do not need it
