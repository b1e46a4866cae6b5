"""Diffusion policies with LeRobot: recorded, trained, loaded in every format, and compared."""

import json
import re
import shutil
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

pytest.importorskip("lerobot")

import compare
from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.agents.diffusion import collection, demonstrations, hub
from aicon_baselines.agents.diffusion.agent import Agent, _generator
from aicon_baselines.agents.diffusion.checkpoint import load, save
from aicon_baselines.agents.diffusion.collection import collect
from aicon_baselines.agents.diffusion.dataset import read
from aicon_baselines.agents.diffusion.demonstrations import Recording
from aicon_baselines.agents.diffusion.export import export
from aicon_baselines.agents.diffusion.installed import import_lerobot
from aicon_baselines.agents.diffusion.network import make_config
from aicon_baselines.agents.diffusion.settings import Training
from aicon_baselines.agents.diffusion.training import train
from aicon_baselines.evaluation.run_folder import read_rows
from aicon_baselines.tasks import load as load_task

STUDENT = Path(__file__).parent.parent / "baselines" / "checkpoints" / "diffusion_pusht_keypoints"
SMALL: dict[str, Any] = {"down_dims": (8, 16), "batch": 8, "warmup": 2}
QUICK: dict[str, Any] = {"max_speed": 800.0, "smoothing": 0.1}


@pytest.fixture(scope="module")
def demos(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("demos") / "data"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(demonstrations, "CHUNK", 2)
        patch.setattr(collection, "CHUNK", 2)
        collect(Recording(episodes=3, observations=("keypoints", "pixels"), **QUICK), folder)
    return folder


@pytest.fixture(scope="module")
def policy(demos: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("training")
    assert train(Training(20, **SMALL), demos, folder, checkpoint=20) == 20
    return folder / "policy"


@pytest.fixture(scope="module")
def observations() -> list[dict[str, np.ndarray]]:
    """What 4 robots see in 12 steps."""
    rng = np.random.default_rng(0)
    return [
        {"environment_state": rng.uniform(100, 400, (4, 16)), "agent_pos": rng.uniform(100, 400, (4, 2))}
        for _ in range(12)
    ]


def run(agent: Agent, observations: list[dict[str, np.ndarray]], starts: dict[int, list[int]]) -> np.ndarray:
    """Return the actions (T, B, 2); `starts` lists the rows whose episode begins, by step."""
    memory, actions = None, []
    for t, observation in enumerate(observations):
        start = np.isin(np.arange(len(observation["agent_pos"])), starts.get(t, []))
        action, memory = agent.predict(observation, memory, start)
        actions.append(action)
    return np.stack(actions)


# --- data


def test_what_was_recorded_is_what_is_read(demos: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(demonstrations, "CHUNK", 2)
    frames = read(demos, "keypoints")
    reference = import_lerobot("datasets.lerobot_dataset").LeRobotDataset(
        "local/data", root=demos, delta_timestamps={"action": [-0.1, 0.0, 0.1]}
    )
    assert len(frames) == len(reference) and len(np.unique(frames.first)) == reference.num_episodes == 3
    for i in (0, 5, int(frames.last[0]), int(frames.last[0]) + 1, len(frames) - 1):
        values, padded = frames.windows(np.array([i]), {"action": [-1, 0, 1], "observation.state": [0]})
        assert np.array_equal(values["action"][0], reference[i]["action"].numpy())
        assert np.array_equal(padded["action"][0], reference[i]["action_is_pad"].numpy())
        assert np.array_equal(values["observation.state"][0, 0], reference[i]["observation.state"].numpy())
    pictures = read(demos, "pixels").columns["observation.image"]
    expected = demonstrations.record_chunk(Recording(observations=("pixels",), **QUICK), 0)[0]["observation.image"]
    assert np.array_equal(pictures[: len(expected)], np.moveaxis(expected, -1, 1))


def test_recording_goes_on_where_it_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(demonstrations, "CHUNK", 1)
    monkeypatch.setattr(collection, "CHUNK", 1)
    recording, recorded = Recording(episodes=3, **QUICK), []

    def record(recording: Recording, index: int) -> Any:
        recorded.append(index)
        if len(recorded) == 2:
            raise KeyboardInterrupt
        return demonstrations.record_chunk(recording, index)

    monkeypatch.setattr(collection, "record_chunk", record)
    with pytest.raises(KeyboardInterrupt):
        collect(recording, tmp_path / "demos")
    assert not (tmp_path / "demos").exists()
    with pytest.raises(ComparisonError, match="holds other demonstrations: near is 0.0 there and 0.5 here"):
        collect(Recording(episodes=3, near=0.5, **QUICK), tmp_path / "demos")
    counts: list[int] = []
    collect(recording, tmp_path / "demos", counts.append)
    assert recorded == [0, 1, 1, 2] and sum(counts) == 3
    assert len(np.unique(read(tmp_path / "demos", "keypoints").first)) == 3
    collect(recording, tmp_path / "demos")
    assert recorded == [0, 1, 1, 2]
    with pytest.raises(ComparisonError, match="other demonstrations: episodes is 3 there and 4 here. Choose another"):
        collect(Recording(episodes=4, **QUICK), tmp_path / "demos")


# --- training


def test_a_stopped_training_ends_like_one_that_was_not(demos: Path, tmp_path: Path) -> None:
    config = Training(8, **SMALL)
    train(config, demos, tmp_path / "whole")
    assert train(config, demos, tmp_path / "parts", stop_after=0.0) == 1
    lines: list[str] = []
    assert train(config, demos, tmp_path / "parts", checkpoint=4, report=lines.append) == 8
    assert len(lines) == 2
    for name in ("policy/model.safetensors", "policy/config.json"):
        assert (tmp_path / "whole" / name).read_bytes() == (tmp_path / "parts" / name).read_bytes()
    with pytest.raises(ComparisonError, match="another training: batch is 8 there and 16 here. Choose another folder"):
        train(Training(8, **SMALL | {"batch": 16}), demos, tmp_path / "parts")


def test_a_training_goes_on_with_more_steps(demos: Path, tmp_path: Path) -> None:
    train(Training(4, **SMALL), demos, tmp_path)
    assert train(Training(6, **SMALL), demos, tmp_path) == 6
    assert json.loads((tmp_path / "training.json").read_text())["steps"] == 6


def test_observations_are_shifted_by_standard_deviations(demos: Path, policy: Path) -> None:
    frames = read(demos, "keypoints")
    names = ("observation.state", "observation.environment_state")
    seen = load(policy).preprocess({name: torch.from_numpy(frames.columns[name]) for name in names})
    for name in names:
        assert torch.allclose(seen[name].mean(dim=0), torch.tensor(2.0), atol=1e-2)
        assert torch.allclose(seen[name].std(dim=0), torch.tensor(1.0), atol=1e-2)


def test_training_lowers_the_loss(demos: Path, tmp_path: Path) -> None:
    train(Training(200, **SMALL | {"batch": 32}, learning_rate=3e-3), demos, tmp_path)
    lines = [line.split(",") for line in (tmp_path / "loss.csv").read_text().splitlines()]
    assert lines[0] == ["step", "loss", "learning_rate", "seconds"]
    assert [line[0] for line in lines[1:]] == ["100", "200"]
    assert float(lines[2][1]) < 0.95 * float(lines[1][1])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda folder: shutil.rmtree(folder), "is no LeRobotDataset, meta/info.json is missing; record one: python"),
        (lambda folder: rename(folder, "observation.environment_state", "keys"), "has 'observation.environment_state'"),
        (lambda folder: rename(folder, "action", "command"), "has 'action' of shape None, expected (2,); its features"),
    ],
)
def test_another_dataset_is_an_error(change: Any, message: str, demos: Path, tmp_path: Path) -> None:
    folder = shutil.copytree(demos, tmp_path / "demos")
    change(folder)
    with pytest.raises(ComparisonError, match=re.escape(message)):
        read(folder, "keypoints")


def rename(folder: Path, old: str, new: str) -> None:
    path = folder / "meta" / "info.json"
    path.write_text(path.read_text().replace(f'"{old}"', f'"{new}"'))


# --- acting


def test_an_agent_acts_as_lerobot_does(policy: Path, observations: list[dict[str, np.ndarray]]) -> None:
    """The same checkpoint, the same noise: LeRobot's own loading, preprocessing, queues and unnormalisation."""
    agent = Agent(policy, "DDIM", 5)
    reference = import_lerobot("policies.diffusion.modeling_diffusion").DiffusionPolicy.from_pretrained(
        policy, cli_overrides=["--noise_scheduler_type=DDIM", "--num_inference_steps=5"]
    )
    before, after = import_lerobot("policies.factory").make_pre_post_processors(
        reference.config, pretrained_path=str(policy)
    )
    reading = import_lerobot("envs.utils").preprocess_observation
    memory: Any = None
    for observation in observations:
        action, memory = agent.predict(observation, memory, np.zeros(4, np.bool_))
        seeds = zip(memory["key"].tolist(), (memory["samples"] - 1).tolist(), strict=True)
        states = [int(np.random.SeedSequence(pair).generate_state(1, np.uint64)[0]) for pair in seeds]
        noise = torch.stack([torch.randn(16, 2, generator=_generator(state)) for state in states])
        expected = after(reference.select_action(before(reading(observation)), noise=noise))
        assert np.allclose(action, expected.numpy(), atol=1e-3)


@pytest.mark.parametrize("sampler", ["DDPM", "DDIM"])
def test_rows_are_separate_robots(policy: Path, observations: list[dict[str, np.ndarray]], sampler: str) -> None:
    agent = Agent(policy, sampler, 5)
    starts = {3: [1], 7: [0, 2], 8: [2]}
    together = run(agent, observations, starts)
    assert together.shape == (12, 4, 2)
    for row in range(4):
        alone = [{name: value[row : row + 1] for name, value in each.items()} for each in observations]
        begins = {t: [0] for t, rows in starts.items() if row in rows}
        assert np.allclose(run(agent, alone, begins)[:, 0], together[:, row], atol=1e-2)
    turned = [{name: value[::-1] for name, value in each.items()} for each in observations]
    assert np.allclose(
        run(agent, turned, {t: [3 - row for row in rows] for t, rows in starts.items()})[:, ::-1], together, atol=1e-2
    )


def test_an_episode_depends_on_its_start_and_the_seed_alone(
    policy: Path, observations: list[dict[str, np.ndarray]]
) -> None:
    agent, other = Agent(policy, "DDPM", 5), Agent(policy, "DDPM", 5, seed=1)
    once = run(agent, observations, {})
    torch.manual_seed(5)
    assert np.array_equal(run(agent, observations, {}), once)
    assert not np.allclose(run(other, observations, {}), once, atol=1.0)
    # An episode that begins in the middle goes as if it had begun at first.
    assert np.allclose(run(agent, observations[4:], {}), run(agent, observations, {4: [0, 1, 2, 3]})[4:], atol=1e-2)


def test_an_episode_that_ended_is_not_sampled_again(
    policy: Path, observations: list[dict[str, np.ndarray]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a comparison it stays in the batch, its observation unchanged, and begins anew at every step."""
    agent, calls = Agent(policy, "DDIM", 2), []
    sample = agent._sample
    monkeypatch.setattr(agent, "_sample", lambda *arguments: calls.append(len(arguments[1])) or sample(*arguments))
    actions = run(agent, observations[:1] * 6, {t: [0, 1, 2, 3] for t in range(6)})
    assert calls == [4]
    assert all(np.array_equal(action, actions[0]) for action in actions)


def test_stochastic_actions_differ(policy: Path, observations: list[dict[str, np.ndarray]]) -> None:
    agent = Agent(policy, "DDIM", 2)
    first, _ = agent.predict(observations[0], deterministic=False)
    second, _ = agent.predict(observations[0], deterministic=False)
    assert not np.allclose(first, second)


def test_a_policy_that_sees_pictures_gets_them(demos: Path, tmp_path: Path) -> None:
    train(Training(1, observation="pixels", **SMALL | {"batch": 2}), demos, tmp_path)
    agent = Agent(tmp_path / "policy", "DDIM", 2)
    for condition in ("deterministic", "upstream"):
        env = load_task("pusht").make_env(2, condition, 5, **agent.env_options)
        observation, _ = env.reset(seed=[1000, 1001], options={})
        assert observation["pixels"].shape == (2, 96, 96, 3)
        action, memory = agent.predict(observation)
        alone, _ = agent.predict({name: value[:1] for name, value in observation.items()})
        assert np.allclose(action[:1], alone, atol=1e-2)
        env.step(action)
        assert agent.predict(observation, memory, np.zeros(2, np.bool_))[0].shape == (2, 2)
        env.close()
    assert agent.name.startswith("diffusion_pixels_ddim2_")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"environment_state": np.zeros((4, 12))}, "observes environment_state (16,), and this condition offers"),
        ({"agent_pos": np.full((4, 2), np.nan)}, "agent_pos has missing values"),
    ],
)
def test_other_readings_are_an_error(
    change: dict[str, Any], message: str, policy: Path, observations: list[dict[str, np.ndarray]]
) -> None:
    with pytest.raises(ComparisonError, match=re.escape(message)):
        Agent(policy).predict(observations[0] | change)


# --- formats


def make_old(policy: Path, folder: Path, oldest: bool) -> Path:
    """Write a policy in a format with the normalisation inside the weights."""
    from safetensors.torch import load_file, save_file

    folder.mkdir()
    content = json.loads((policy / "config.json").read_text())
    statistics = load_file(next(policy.glob("policy_preprocessor_step_*_normalizer_processor.safetensors")))
    weights = load_file(policy / "model.safetensors")
    modes = {"observation.state": "mean_std", "observation.environment_state": "mean_std", "action": "min_max"}
    for name, mode in modes.items():
        layers = ("normalize_targets", "unnormalize_outputs") if name == "action" else ("normalize_inputs",)
        for layer in layers:
            for part in mode.split("_"):
                value = statistics[f"{name}.{part}"].float().clone()
                weights[f"{layer}.buffer_{name.replace('.', '_')}.{part}"] = value
    if oldest:
        inputs, outputs = content.pop("input_features"), content.pop("output_features")
        content["input_shapes"] = {name: feature["shape"] for name, feature in inputs.items()}
        content["output_shapes"] = {name: feature["shape"] for name, feature in outputs.items()}
        content["input_normalization_modes"] = {name: modes[name] for name in inputs}
        content["output_normalization_modes"] = {name: modes[name] for name in outputs}
        del content["type"], content["normalization_mapping"], content["device"], content["use_amp"]
    else:
        content["normalization_mapping"].pop("ENV")  # the defaults of that time had none
    (folder / "config.json").write_text(json.dumps(content))
    save_file(weights, folder / "model.safetensors")
    return folder


@pytest.mark.parametrize("oldest", [True, False])
def test_old_formats_act_like_todays(
    oldest: bool, policy: Path, tmp_path: Path, observations: list[dict[str, np.ndarray]]
) -> None:
    old = make_old(policy, tmp_path / "old", oldest)
    expected = run(Agent(policy, "DDIM", 5), observations, {})
    assert np.allclose(run(Agent(old, "DDIM", 5), observations, {}), expected, atol=1e-2)


def test_a_newer_version_is_read(policy: Path, tmp_path: Path) -> None:
    folder = shutil.copytree(policy, tmp_path / "policy")
    edit(folder, gradient_checkpointing=False, pretrained_revision=None)
    assert Agent(folder).name == Agent(policy).name


def test_half_precision_is_loaded_as_float32(
    policy: Path, tmp_path: Path, observations: list[dict[str, np.ndarray]]
) -> None:
    from safetensors.torch import load_file

    export(policy.parent, tmp_path / "half", sampler="DDIM", inference_steps=5)
    assert (tmp_path / "half" / "loss.png").stat().st_size < 100_000
    assert {value.dtype for value in load_file(tmp_path / "half" / "model.safetensors").values()} == {torch.float16}
    ours = load(tmp_path / "half").policy
    theirs = import_lerobot("policies.diffusion.modeling_diffusion").DiffusionPolicy.from_pretrained(tmp_path / "half")
    for one, other in zip(ours.parameters(), theirs.parameters(), strict=True):
        assert one.dtype == other.dtype == torch.float32 and torch.equal(one, other)
    assert theirs.diffusion.num_inference_steps == 5
    difference = run(Agent(tmp_path / "half"), observations[:4], {}) - run(
        Agent(policy, "DDIM", 5), observations[:4], {}
    )
    assert np.abs(difference).max() < 2.0  # px


def test_the_student_that_comes_along_is_small_and_loads(observations: list[dict[str, np.ndarray]]) -> None:
    assert sum(file.stat().st_size for file in STUDENT.iterdir()) < 20e6
    agent, theirs = Agent(STUDENT), import_lerobot("policies.diffusion.modeling_diffusion").DiffusionPolicy
    loaded = theirs.from_pretrained(STUDENT)
    for one, other in zip(agent._checkpoint.policy.parameters(), loaded.parameters(), strict=True):
        assert torch.equal(one, other)
    actions = run(agent, observations, {})
    assert actions.shape == (12, 4, 2) and (actions > 0.0).all() and (actions < 512.0).all()


def test_pixel_policies_keep_their_options(demos: Path, tmp_path: Path) -> None:
    config = make_config(Training(1, observation="pixels", **SMALL), read(demos, "pixels").features)
    assert config.crop_shape == (84, 84) and config.use_group_norm
    network = import_lerobot("policies.diffusion.modeling_diffusion").DiffusionPolicy(config)
    processors = import_lerobot("policies.factory").make_pre_post_processors(
        config, dataset_stats=read(demos, "pixels").statistics
    )
    save(network, *processors, tmp_path / "policy")
    again = load(tmp_path / "policy").policy.config
    assert (again.crop_shape, again.down_dims, again.use_group_norm) == ((84, 84), (8, 16), True)


# --- in a comparison


def test_rows_do_not_depend_on_how_they_were_run(policy: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def rows(folder: str, *arguments: object) -> list[Any]:
        usual = ("--task", "pusht", "--seed", 1000, "--horizon", 20, "--conditions", "deterministic", "noise_2")
        options = (*usual, "--sampler", "DDPM", "--inference-steps", 3, "--out", tmp_path / folder, *arguments)
        monkeypatch.setattr(sys, "argv", ["script", *map(str, options)])
        compare.main()
        return read_rows(tmp_path / folder / "episodes.csv")

    both = rows("a", "--episodes", 3, "--policies", "diffusion", "steepest", "--diffusion-path", policy)
    students = [row for row in both if row.policy != "steepest"]
    assert {row.policy for row in students} == {Agent(policy, "DDPM", 3).name} and len(students) == 6
    rows("b", "--episodes", 3, "--policies", "steepest")
    lines = (tmp_path / "a" / "episodes.csv").read_text().splitlines(keepends=True)
    (tmp_path / "b" / "episodes.csv").write_text("".join(lines[:2]))  # as if stopped after the first row
    again = rows("b", "--episodes", 3, "--policies", "diffusion", "--diffusion-path", policy)
    assert [row for row in again if row.policy != "steepest"] == students


# --- bad input


def edit(folder: Path, **values: Any) -> None:
    path = folder / "config.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | values))


def remove_processors(folder: Path) -> None:
    for file in folder.glob("policy_*"):
        file.unlink()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda f: (f / "config.json").unlink(),
            "is no saved policy, config.json is missing; train one: python scripts",
        ),
        (lambda f: (f / "config.json").write_text("x"), "config.json is not JSON"),
        (lambda f: edit(f, type="act"), "config.json describes a policy of type 'act', not 'diffusion'"),
        (lambda f: edit(f, colour="red"), "options that the installed LeRobot does not know: colour; save the policy"),
        (lambda f: edit(f, down_dims=[8, 16, 32, 64, 128]), "config.json is not a diffusion policy's"),
        (lambda f: edit(f, down_dims=[16, 32]), "model.safetensors does not fit"),
        (lambda f: edit(f, output_features={"action": {"type": "ACTION", "shape": [7]}}), "and gives {'action': (7,)}"),
        (lambda f: (f / "model.safetensors").unlink(), "has no model.safetensors; copy the whole folder"),
        (lambda f: (f / "model.safetensors").write_text("x"), "model.safetensors holds no weights"),
        (remove_processors, "has no policy_preprocessor.json and policy_postprocessor.json, and model.safetensors no"),
    ],
)
def test_a_folder_that_is_no_policy_is_an_error(change: Any, message: str, policy: Path, tmp_path: Path) -> None:
    folder = shutil.copytree(policy, tmp_path / "policy")
    change(folder)
    with pytest.raises(ComparisonError, match=re.escape(message)):
        Agent(folder)


def test_the_folder_of_a_training_points_to_its_policy(policy: Path) -> None:
    with pytest.raises(ComparisonError, match=re.escape(f"config.json is missing; take {policy}")):
        Agent(policy.parent)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"sampler": "EULER"}, "unknown sampler 'EULER'; valid samplers: DDPM, DDIM"),
        ({"inference_steps": 101}, "inference steps must be between 1 and 100, not 101"),
    ],
)
def test_samplers_that_do_not_exist_are_an_error(options: dict[str, Any], message: str, policy: Path) -> None:
    with pytest.raises(ComparisonError, match=re.escape(message)):
        Agent(policy, **options)


@pytest.mark.parametrize("offline", [True, False])
def test_without_the_hub_an_error_says_what_to_download(
    offline: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from huggingface_hub import constants

    monkeypatch.setattr(constants, "HF_HUB_CACHE", str(tmp_path))
    monkeypatch.setattr(constants, "HF_HUB_OFFLINE", offline)
    monkeypatch.setattr(constants, "ENDPOINT", "http://127.0.0.1:9")
    reason = "HF_HUB_OFFLINE is set" if offline else "does not answer"
    with pytest.raises(
        ComparisonError, match=rf"{reason}.*Download config.json.*--diffusion-path runs/diffusion_pusht"
    ):
        Agent("lerobot/diffusion_pusht")


def test_what_was_downloaded_before_is_found(policy: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from huggingface_hub import constants

    monkeypatch.setattr(constants, "HF_HUB_CACHE", str(tmp_path))
    kept = tmp_path / "models--owner--name"
    shutil.copytree(policy, kept / "snapshots" / "0123")
    (kept / "refs").mkdir()
    (kept / "refs" / "main").write_text("0123")
    assert hub.locate("owner/name") == kept / "snapshots" / "0123"
