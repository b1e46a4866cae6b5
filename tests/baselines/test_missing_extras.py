"""Without an extra, whatever needs it says in a sentence how to install it."""

import sys
from importlib import import_module

import pytest
from gymnasium.error import DependencyNotInstalled

from aicon_baselines.agents import reach
from aicon_baselines.agents.diffusion.lerobot_names import import_lerobot
from aicon_baselines.agents.registry import import_mppi, import_sb3
from aicon_baselines.evaluation import ComparisonError
from aicon_baselines.evaluation.backends import joblib_backend
from aicon_baselines.extras import EXTRAS
from aicon_baselines.tasks import load, upstream
from aicon_torch.parts import Chain

# What is missing, what is imported then, and the extra that is named.
IMPORTS = [
    ("joblib", "aicon_baselines.evaluation.comparison", "compare"),
    ("joblib", "aicon_baselines.evaluation.backends", "compare"),
    ("tqdm", "aicon_baselines.evaluation.progress", "compare"),
    ("tqdm", "aicon_baselines.evaluation.timing", "compare"),
    ("matplotlib", "aicon_baselines.evaluation.curves", "compare"),
    ("matplotlib", "aicon_baselines.evaluation.study", "compare"),
    ("matplotlib", "aicon_baselines.figures", "compare"),
    ("pymunk", "aicon_envs.pusht", "pusht"),
    ("pygame", "aicon_envs.pusht.rendering", "pusht"),
    ("mujoco", "aicon_envs.arm_push", "panda"),
    ("viser", "aicon_baselines.view", "view"),
]


def hide(monkeypatch: pytest.MonkeyPatch, missing: str, importer: str = "") -> None:
    """Let a module be missing, and forget what has imported it."""
    monkeypatch.setitem(sys.modules, missing, None)
    for name in list(sys.modules):
        if name.startswith(f"{missing}."):
            monkeypatch.setitem(sys.modules, name, None)
        elif importer and (name == importer or name.startswith(f"{importer}.")):
            monkeypatch.delitem(sys.modules, name)


@pytest.mark.parametrize(("missing", "importer", "extra"), IMPORTS)
def test_an_import_names_the_extra(
    monkeypatch: pytest.MonkeyPatch, missing: str, importer: str, extra: str
) -> None:
    hide(monkeypatch, missing, importer)
    command = rf"""pip install ['"]aicon-torch\[{extra}\]['"]"""
    with pytest.raises((ModuleNotFoundError, DependencyNotInstalled), match=command):
        import_module(importer)


def test_the_view_names_its_extra_where_nothing_that_it_brings_is_there(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "rich", None)
    hide(monkeypatch, "viser", "aicon_baselines.view")
    with pytest.raises(ModuleNotFoundError, match=r"pip install 'aicon-torch\[view\]'"):
        import_module("aicon_baselines.view")


def test_arms_that_reach_name_their_extra_where_mujoco_is_missing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for importer in ("aicon_envs.arm_push", "aicon_envs.reach"):
        hide(monkeypatch, "mujoco", importer)
    with pytest.raises(DependencyNotInstalled, match=r"for the task reach, \"aicon-torch\[reach\]"):
        import_module("aicon_envs.reach")


@pytest.mark.parametrize(("missing", "task"), [("pymunk", "pusht"), ("mujoco", "arm_push")])
def test_a_task_names_the_extra(monkeypatch: pytest.MonkeyPatch, missing: str, task: str) -> None:
    hide(monkeypatch, missing, f"aicon_envs.{task}")
    hide(monkeypatch, missing, f"aicon_baselines.tasks.{task}")
    with pytest.raises(ComparisonError, match=r"pip install .aicon-torch\[(pusht|panda)\]"):
        load(task)


def test_what_is_imported_when_it_is_needed_names_the_extra(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for module in ("stable_baselines3", "distributed", "lerobot", "pytorch_mppi"):
        hide(monkeypatch, module)
    hide(monkeypatch, "stable_baselines3", "aicon_baselines.agents.sb3")
    hide(monkeypatch, "pytorch_mppi", "aicon_baselines.agents.mppi")

    with pytest.raises(ComparisonError, match=r"pip install 'aicon-torch\[sb3\]'"):
        import_sb3()
    with pytest.raises(ComparisonError, match=r"pip install 'aicon-torch\[lerobot\]'"):
        import_lerobot("policies.factory")
    with pytest.raises(ComparisonError, match=r"pip install 'aicon-torch\[peers\]'"):
        import_mppi()
    message = r"pip install 'aicon-torch\[cluster\]'"
    with pytest.raises(ComparisonError, match=message), joblib_backend("dask", 1, None):
        pass


@pytest.mark.parametrize(("opponent", "extra"), [("Mink", "peers"), ("Pink", "kinematics")])
def test_inverse_kinematics_names_its_extra(
    monkeypatch: pytest.MonkeyPatch, opponent: str, extra: str
) -> None:
    for module in getattr(reach, opponent).modules:
        hide(monkeypatch, module)
    with pytest.raises(ComparisonError, match=rf"pip install 'aicon-torch\[{extra}\]'"):
        getattr(reach, opponent)()


def test_the_condition_upstream_names_its_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    hide(monkeypatch, "gym_pusht")
    with pytest.raises(ComparisonError, match=r"pip install 'aicon-torch\[upstream\]'"):
        upstream.UpstreamPushT()


def test_a_chain_names_its_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    hide(monkeypatch, "pytorch_kinematics")
    turned = '<joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>'
    robot = f'<robot name="r"><link name="a"/><link name="b"/>{turned}</robot>'
    with pytest.raises(ModuleNotFoundError, match=r"pip install 'aicon-torch\[robots\]'"):
        Chain.from_urdf(robot)


def test_a_robot_that_reaches_names_its_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("mujoco")
    urdf = import_module("aicon_envs.reach.urdf")
    robots = import_module("aicon_envs.reach.robots").ROBOTS

    hide(monkeypatch, "trimesh")
    with pytest.raises(ModuleNotFoundError, match=r"pip install 'aicon-torch\[reach\]'"):
        urdf.read_description(robots["kinova"])  # whose meshes are Collada


def test_every_extra_is_tried() -> None:
    when_imported = {extra for _, _, extra in IMPORTS}
    when_needed = {"sb3", "lerobot", "cluster", "peers", "kinematics", "upstream", "robots"}
    when_needed |= {"reach", "compiler"}
    assert when_imported | when_needed == set(EXTRAS)
