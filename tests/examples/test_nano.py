"""nano-AICON is the library's navigation, line by line, to rounding."""

import importlib.util
from pathlib import Path
from types import ModuleType
from typing import Any

import gymnasium as gym
import pytest
import torch

import aicon_envs  # noqa: F401  (registers the environments)
from aicon_baselines.tasks import load
from aicon_torch import Policy, Sensor, WorldModel, make_policy

NANO = Path(__file__).parents[2] / "examples" / "nano.py"


@pytest.fixture
def nano() -> Any:
    """The example, whose precision stays its own."""
    spec = importlib.util.spec_from_file_location("nano", NANO)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    default = torch.get_default_dtype()
    try:
        spec.loader.exec_module(module)
        yield module
    finally:
        torch.set_default_dtype(default)


@pytest.fixture
def policy() -> Policy:
    """The library's, which believes every reading, as nano does."""
    shipped = make_policy("nav2d")
    declared = shipped.model.declaration
    model = WorldModel(
        sensors={"z_tar": Sensor(1, "rad", key="bearing"), "z_obs": Sensor(1, "m", key="range")},
        actuators={"a": declared.actuators["a"]},
        estimators=declared.estimators,
        goals=list(declared.goals.values()),
        dt=declared.dt,
        dtype=torch.float64,
    )
    return Policy(model, shipped.resolution, shipped.law)


def as_in_nano(nano: ModuleType, memory: dict[str, torch.Tensor]) -> Any:
    """The library's memory, as nano writes it."""
    return nano.Memory(
        target=(memory["p_tar"], memory["P_tar"]),
        wall=(memory["x_obs"], memory["P_obs"]),
        action=memory["a"],
        step=int(memory["steps"]),
        ranks=tuple(memory["x_rob/rank"].tolist()),
        average=memory["x_rob/average"],
        exploring=bool(memory["x_rob/exploring"]),
        moved=memory["x_rob/displacement"],
    )


def difference(first: Any, second: Any) -> float:
    """The largest difference of two memories; what is no tensor must be the same."""
    if isinstance(first, torch.Tensor):
        return float((first - second).abs().max())
    if isinstance(first, tuple):
        return max(difference(one, other) for one, other in zip(first, second, strict=True))
    return 0.0 if first == second else float("inf")


@pytest.mark.parametrize(
    "steps", [15, pytest.param(1000, marks=pytest.mark.slow, id="whole_episode")]
)
def test_every_step_in_the_first_trap_is_the_librarys(
    nano: Any, policy: Policy, steps: int
) -> None:
    """Each from the same memory: a closed loop along a wall amplifies the last bit."""
    if steps > 100:
        policy = policy.compile()
    env = gym.make("aicon/Nav2D-v0")
    episode = load("nav2d").episode(0)
    options = {"map": episode.map, "map_seed": episode.seed}
    readings, info = env.reset(seed=episode.noise_seed, options=options)
    memory: Any = None
    explored = 0

    for _ in range(steps):
        bearing = torch.tensor(readings["bearing"]).double()
        clearance = torch.tensor(readings["range"]).double()
        before = (
            nano.begin(bearing[0], clearance[0]) if memory is None else as_in_nano(nano, memory)
        )
        after = nano.act(before, bearing[0], clearance[0])
        action, memory = policy.predict({"bearing": bearing, "range": clearance}, memory)
        assert difference(after, as_in_nano(nano, memory)) <= 1e-12
        explored += after.exploring

        readings, _, ended, _, info = env.step(action.numpy())
        if ended:
            break
    assert steps < 1000 or (info["is_success"] and explored > 50)


def test_it_is_short_and_imports_torch_alone() -> None:
    text = NANO.read_text()
    imports = [line for line in text.splitlines() if line.startswith(("import", "from"))]
    assert len(text.splitlines()) <= 150
    assert {line.split()[1].split(".")[0] for line in imports} == {"typing", "torch"}
