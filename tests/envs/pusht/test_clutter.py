"""Clutter changes the picture that a policy is given, and nothing else."""

import numpy as np
import pytest

from aicon_envs.pusht import PushTEnv
from aicon_envs.pusht.clutter import Clutter, Kind

pytest.importorskip("pygame")

TARGET = np.array([200.0, 200.0], np.float32)


def pictures(kind: Kind | None, seed: int = 0) -> list[np.ndarray]:
    """What is seen at the start and after two steps."""
    env = PushTEnv(obs_type="pixels_agent_pos")
    cluttered = env if kind is None else Clutter(env, kind)
    seen = [cluttered.reset(seed=seed)[0]]
    seen += [cluttered.step(TARGET)[0] for _ in range(2)]
    return [np.array(observation["pixels"]) for observation in seen]


def drawn(kind: Kind, seed: int = 0) -> list[np.ndarray]:
    """Which pixels differ from the world's own, ``(96, 96)``."""
    pairs = zip(pictures(kind, seed), pictures(None, seed), strict=True)
    return [(ours != plain).any(-1) for ours, plain in pairs]


def test_a_third_is_covered_elsewhere_at_each_step() -> None:
    covers = drawn("covered")
    assert all(0.2 < cover.mean() <= 0.36 for cover in covers)
    assert not np.array_equal(covers[0], covers[1])


@pytest.mark.parametrize("kind", ["distractors", "hidden"])
def test_what_is_fixed_stays_where_it_is(kind: Kind) -> None:
    first, *others = pictures(kind)
    mask = drawn(kind)[0]
    assert mask.any() and all(np.array_equal(first[mask], other[mask]) for other in others)


def test_the_same_seed_draws_the_same() -> None:
    assert all(map(np.array_equal, pictures("covered", 3), pictures("covered", 3)))
    assert not np.array_equal(pictures("hidden", 3)[0], pictures("hidden", 4)[0])


def test_it_needs_pictures_and_a_kind() -> None:
    with pytest.raises(ValueError, match="pixels_agent_pos"):
        Clutter(PushTEnv(), "hidden")
    with pytest.raises(ValueError, match="kind must be one of distractors"):
        Clutter(PushTEnv(obs_type="pixels_agent_pos"), "fog")  # type: ignore[arg-type]
