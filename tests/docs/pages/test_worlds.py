"""The worlds of the pages are those of the environments."""

import json
from typing import Any

import numpy as np
import pytest

from aicon_envs.nav2d.boundaries import Boundaries
from building import scripts

pytestmark = pytest.mark.skipif(not scripts.has_node(), reason="no Node.js")


def in_node(program: str, given: Any = None) -> Any:
    """What a program prints, in JSON; it has ``given``, and ``at``, where the scripts are."""
    head = f"const given = {json.dumps(given)}, at = {json.dumps(scripts.SOURCES.as_uri())};\n"
    return json.loads(scripts.run("node", "--input-type=module", "-", given=head + program))


def test_distances_to_walls_are_those_of_the_environment() -> None:
    from building.navigation import map_of, physics

    world = map_of("maze", 1000)
    places = np.random.default_rng(0).uniform(-4.0, 4.0, (50, 2))
    found = in_node(
        """
        const { NavigationWorld } = await import(`${at}/worlds/navigation.mjs`);
        const world = new NavigationWorld(given.map, given.physics, 0);
        console.log(JSON.stringify(given.places.map((place) => world.clearance(place))));
        """,
        {"map": world, "physics": physics(), "places": places.tolist()},
    )

    boundaries = Boundaries(1)
    boundaries.load([0], [[[tuple(corner) for corner in wall] for wall in world["obstacles"]]])
    expected = [np.linalg.norm(boundaries.nearest(place[:, None])) - 0.1 for place in places]
    outside = (
        np.array(found) < np.array(expected) + 0.05
    )  # walls overlap: within one there is another
    assert np.mean(outside) > 0.5
    np.testing.assert_allclose(np.array(found)[outside], np.array(expected)[outside], atol=1e-9)


def test_a_moment_comes_back_bit_by_bit() -> None:
    numbers = [0.1, -1e300, 5e-324, 1 / 3, 2.0**53 + 2]
    found = in_node(
        """
        const { fromHash, toHash } = await import(`${at}/core/moment.mjs`);
        const moment = { seed: 12, variant: "sum+explore", world: given, memory: [NaN, ...given] };
        const back = fromHash(toHash(moment));
        console.log(JSON.stringify({ ...back, gap: Number.isNaN(back.memory[0]) }));
        """,
        numbers,
    )
    assert (found["seed"], found["variant"]) == (12, "sum+explore")
    assert found["world"] == numbers and found["memory"][1:] == numbers and found["gap"]


def test_random_numbers_are_normal_and_repeat() -> None:
    first, again, other = in_node(
        """
        const { Random } = await import(`${at}/core/random.mjs`);
        const draw = (seed) => {
            const random = new Random(seed);
            return Array.from({ length: 4000 }, () => random.normal());
        };
        console.log(JSON.stringify([draw(1), draw(1), draw(2)]));
        """
    )
    assert first == again != other
    assert np.mean(first) == pytest.approx(0.0, abs=0.05)
    assert np.std(first) == pytest.approx(1.0, abs=0.05)
    assert abs(np.corrcoef(first, other)[0, 1]) < 0.05


@pytest.mark.slow
def test_the_t_is_pushed_home_in_planck() -> None:
    """From ten starts that are not reported."""
    pytest.importorskip("ziglang", reason="no ziglang (pip install ziglang)")
    from aicon_torch import make_policy
    from building.pushing import table
    from count_starts import in_the_page, start_of

    starts = [start_of(seed) for seed in range(1000, 1010)]
    rows = in_the_page("pusht", make_policy("pusht", observe_goal=True), table(), starts)
    assert sum(row["success"] for row in rows) >= 9
