"""No file of an agent runs code, unless the user trusts where it comes from."""

import pickle
import shutil
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

pytest.importorskip("stable_baselines3")
pytest.importorskip("pymunk")

import stable_baselines3
from stable_baselines3.common.vec_env import DummyVecEnv

from aicon_baselines.agents import sb3
from aicon_baselines.agents.registry import saved_agent
from aicon_baselines.agents.sb3.agent_folder import load_agent
from aicon_baselines.agents.sb3.environments import make_training_envs, normalize
from aicon_baselines.agents.sb3.replay_file import load_replay_buffer, save_replay_buffer
from aicon_baselines.evaluation import ComparisonError

Folders = dict[tuple[str, str], Path]


class Intruder:
    """Something that makes a file where it is unpickled."""

    def __init__(self, trace: Path) -> None:
        self.trace = trace

    def __reduce__(self) -> tuple[Any, ...]:
        return Path.touch, (self.trace,)


@pytest.fixture
def folder(agent_folders: Folders, tmp_path: Path) -> Path:
    """The folder of an agent, to be spoilt."""
    return Path(shutil.copytree(agent_folders["nav2d", "sac"], tmp_path / "agent"))


def replace_member(archive: Path, name: str, content: bytes) -> None:
    """Exchange one file in a zip."""
    with zipfile.ZipFile(archive) as before:
        members = {each: before.read(each) for each in before.namelist()}
    with zipfile.ZipFile(archive, "w") as after:
        for each, old in members.items():
            after.writestr(each, content if each == name else old)


def test_the_description_in_an_agent_is_not_read(folder: Path, tmp_path: Path) -> None:
    replace_member(folder / "agent.zip", "data", pickle.dumps(Intruder(tmp_path / "trace")))
    sb3.Agent(folder, "nav2d")
    assert not (tmp_path / "trace").exists()


def test_weights_that_are_no_tensors_are_refused(folder: Path, tmp_path: Path) -> None:
    intruder = pickle.dumps(Intruder(tmp_path / "trace"), protocol=2)  # as torch writes it
    replace_member(folder / "agent.zip", "policy.pth", intruder)
    with pytest.raises(ComparisonError, match="agent.zip is not an agent of SAC"):
        sb3.Agent(folder, "nav2d")
    assert not (tmp_path / "trace").exists()


def test_a_replay_buffer_that_is_no_array_is_refused(folder: Path, tmp_path: Path) -> None:
    np.savez(folder / "replay_buffer.npz", actions=np.array([Intruder(tmp_path / "trace")]))
    config = sb3.TrainingConfig.for_task("nav2d", "sac", 90, envs=2, rollout=64, horizon=40)
    with pytest.raises(ComparisonError, match="replay_buffer.npz does not hold what this agent"):
        sb3.train(config, folder)
    assert not (tmp_path / "trace").exists()


def test_pickled_statistics_are_read_only_where_they_are_trusted(
    folder: Path, tmp_path: Path
) -> None:
    (folder / "statistics.json").unlink()
    (folder / "vecnormalize.pkl").write_bytes(pickle.dumps(Intruder(tmp_path / "trace")))

    message = r"has no statistics.json.*vecnormalize.pkl can run any code.*--trust"
    with pytest.raises(ComparisonError, match=message):
        saved_agent("nav2d", folder)
    assert not (tmp_path / "trace").exists()

    with pytest.raises(ComparisonError, match="holds no VecNormalize"):
        saved_agent("nav2d", folder, trust=True)
    assert (tmp_path / "trace").exists()


def test_an_agent_with_another_network_is_loaded_where_it_is_trusted(folder: Path) -> None:
    config = sb3.TrainingConfig.for_task("nav2d", "sac", 60, envs=1, horizon=40)
    envs = normalize(make_training_envs(config, 0), config.discount)
    foreign = stable_baselines3.SAC(
        "MultiInputPolicy", envs, buffer_size=10, policy_kwargs={"net_arch": [8]}
    )
    foreign.save(folder / "agent.zip")

    message = r"agent.zip is not an agent of SAC.*another network.*trust.*--trust"
    with pytest.raises(ComparisonError, match=message):
        saved_agent("nav2d", folder)

    _, build = saved_agent("nav2d", folder, trust=True)
    readings = {"bearing": np.zeros((3, 1)), "range": np.ones((3, 1))}
    action, _ = build("range").predict(readings)
    assert action.shape == (3, 2) and np.isfinite(action).all()


def test_numbers_alone_give_the_same_agent(kind: tuple[str, str], agent_folders: Folders) -> None:
    folder = agent_folders[kind]
    config = sb3.Agent(folder, kind[0]).config
    model, statistics = load_agent(folder, config)
    trusted, _ = load_agent(folder, config, trust=True)

    assert statistics is not None
    expected, weights = trusted.get_parameters()["policy"], model.get_parameters()["policy"]
    assert weights.keys() == expected.keys()
    assert all(torch.equal(weights[name], expected[name]) for name in expected)


@pytest.mark.parametrize("steps", [7, 13])
def test_what_sac_remembers_comes_back(steps: int, tmp_path: Path) -> None:
    """Also where it has forgotten the beginning, or is to have less room than before."""

    def remembering(room: int) -> Any:
        config = sb3.TrainingConfig.for_task("nav2d", "sac", room, envs=1, horizon=40)
        envs: DummyVecEnv = make_training_envs(config, 0)  # type: ignore[assignment]
        return stable_baselines3.SAC("MultiInputPolicy", envs, buffer_size=room, learning_starts=99)

    model = remembering(10)
    model.learn(steps)
    save_replay_buffer(tmp_path / "seen.npz", model)

    for room in (5, 10, 20):
        other = remembering(room)
        load_replay_buffer(tmp_path / "seen.npz", other)
        count = min(steps, 10, room)
        assert other.replay_buffer.size() == count
        actions = other.replay_buffer.actions[:count]
        order = (np.arange(count) + steps - count) % 10
        np.testing.assert_array_equal(actions, model.replay_buffer.actions[order])

    with np.load(tmp_path / "seen.npz") as saved:
        uneven = {**saved, "rewards": saved["rewards"][:2]}
    np.savez(tmp_path / "uneven.npz", **uneven)
    with pytest.raises(ComparisonError, match="does not hold what this agent has seen"):
        load_replay_buffer(tmp_path / "uneven.npz", remembering(20))
