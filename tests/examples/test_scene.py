"""The scene of OGBench, where its package is installed."""

from collections.abc import Callable
from importlib.util import find_spec
from typing import Any

import pytest
from _worlds import episodes, succeed


@pytest.mark.slow
@pytest.mark.skipif(not find_spec("ogbench"), reason="needs: make worlds")
@pytest.mark.filterwarnings("ignore")  # of one package about another
def test_a_drawer_is_unlocked_opened_filled_and_shut(world_of: Callable[[str], Any]) -> None:
    played = list(episodes(world_of("ogbench_scene"), "task4", [1001], horizon=300))
    assert max(seen["z_way_drawer"].item() for seen, _ in played) > 0.15  # m
    assert played[-1][1]["is_success"].all()


@pytest.mark.slow
@pytest.mark.skipif(not find_spec("ogbench"), reason="needs: make worlds")
@pytest.mark.filterwarnings("ignore")  # of one package about another
def test_a_cube_is_let_go_before_a_button_is_pressed(world_of: Callable[[str], Any]) -> None:
    assert succeed(world_of("ogbench_scene"), "task3", [1013])


@pytest.mark.slow
@pytest.mark.skipif(not find_spec("ogbench"), reason="needs: make worlds")
@pytest.mark.filterwarnings("ignore")  # of one package about another
@pytest.mark.parametrize("condition", ["task3", "task5"])
def test_a_stack_of_three_is_taken_apart_and_built(
    condition: str, world_of: Callable[[str], Any]
) -> None:
    cubes = world_of("ogbench_cubes")
    assert succeed(cubes, condition, [1001], task=cubes.TRIPLE)
