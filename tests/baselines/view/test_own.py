"""Environments of one's own."""

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

pytest.importorskip("viser", reason="the live view needs the extra [view]")

from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.palette import ROBOT
from aicon_baselines.view import PlaneScene, open_own, serve, watch
from aicon_baselines.view.live import LiveView
from aicon_baselines.worlds import disc
from aicon_torch import Actuator, Affine, Deterministic, Goal, Policy, Sensor, WorldModel


class Corridor(gym.Env[dict[str, Any], Any]):
    """A point that is to come to 1."""

    observation_space = gym.spaces.Dict({"place": gym.spaces.Box(-9.0, 9.0, (2,), np.float64)})
    action_space = gym.spaces.Box(-1.0, 1.0, (2,), np.float64)

    def reset(self, **arguments: Any) -> tuple[dict[str, Any], dict[str, Any]]:
        super().reset(seed=arguments.get("seed"))
        self.place = self.np_random.uniform(-1.0, 0.0, 2)
        return {"place": self.place.copy()}, {"distance": 1.0}

    def step(self, action: Any) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        self.place = self.place + 0.1 * np.asarray(action)
        left = float(np.linalg.norm(self.place - 1.0))
        info = {"distance": left, "is_success": left < 0.1}
        return {"place": self.place.copy()}, -left, left < 0.1, False, info


class CorridorScene(PlaneScene):
    """The corridor from above."""

    remaining_curves = {"distance": (0, 0, 0)}

    def draw_world(self) -> None:
        self.canvas.fit((-2.0, -2.0), (2.0, 2.0))

    def draw_moving(self) -> None:
        place = self.episode.trace.values["x"][0].numpy(force=True)
        self.canvas.draw({"robot": disc(place, 0.1, 1, ROBOT)})
        self.draw_arrows(place)


def make_policy() -> Policy:
    """It comes to 1, and would rather be at 2."""

    def near(x: Any) -> Any:
        return (x - 1.0).norm(dim=-1)

    def far(x: Any) -> Any:
        return 0.2 * (x - 2.0).norm(dim=-1)

    model = WorldModel(
        sensors={"z": Sensor(2, "m", key="place")},
        actuators={"a": Actuator(2, "m/s", limit=1.0)},
        estimators=[Deterministic("x", Affine(z=1.0, a=0.1))],
        goals=[Goal("near", near), Goal("far", far)],
        dt=0.1,
    )
    return Policy(model)


def test_a_scene_of_ones_own_is_two_methods() -> None:
    episode = open_own(make_policy(), Corridor())
    view = LiveView(episode, serve("127.0.0.1", 0), scene=CorridorScene, compiles=False)
    try:
        for _ in range(60):
            view.episode.step()
        view.scene.draw()
        assert view.episode.succeeded and view.scene.headline() == "Arrived"
        assert set(view.scene.strengths()) == {"near", "far"}
        assert view.scene.remaining()["distance"] < 0.1
    finally:
        view.close()


def test_an_environment_that_is_none_of_mujoco_needs_a_scene() -> None:
    with pytest.raises(
        ComparisonError, match="Corridor has no MuJoCo model and data: name a scene"
    ):
        watch(make_policy(), Corridor())
