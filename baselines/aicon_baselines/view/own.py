"""Watching a policy in an environment of one's own."""

from collections.abc import Sequence
from typing import Any

import gymnasium
from gymnasium.vector import AutoresetMode

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.tasks.side_by_side import SideBySide, StandStillAfterEnd
from aicon_baselines.view.episode import LiveEpisode
from aicon_baselines.view.live import LiveView
from aicon_baselines.view.opening import MakeScene
from aicon_baselines.view.server import serve
from aicon_torch import Policy


def open_own(policy: Policy, env: gymnasium.Env[Any, Any], seed: int = 0) -> LiveEpisode:
    """An episode of an environment of one's own, started.

    Args:
        policy: A policy of the library.
        env: The environment; its observations are what the policy reads.
        seed: Seed of the episode.
    """
    name = env.spec.id if env.spec is not None else type(env.unwrapped).__name__
    single = StandStillAfterEnd(env)
    episode = LiveEpisode(
        name, SideBySide([lambda: single], autoreset_mode=AutoresetMode.DISABLED), policy
    )
    episode.start(seed)
    return episode


def watch(
    policy: Policy,
    env: gymnasium.Env[Any, Any],
    scene: MakeScene | None = None,
    *,
    seed: int = 0,
    port: int = 8080,
    host: str = "127.0.0.1",
    names: Sequence[str] = (),
) -> None:
    """Show a policy in an environment of one's own in the browser, until Ctrl-C.

    Args:
        policy: A policy of the library.
        env: The environment; its observations are what the policy reads.
        scene: A class derived from :class:`PlaneScene` or :class:`MuJoCoScene`; an environment that
            has MuJoCo's `model` and `data` needs none.
        seed: Seed of the episode.
        port: Port of the page; where it is taken, the next free one.
        host: Address to listen at; "0.0.0.0" is visible to the whole network.
        names: Names by which the page may be called, besides `localhost` and numeric addresses.

    Raises:
        ComparisonError: If there is no scene, and the environment is none of MuJoCo.
    """
    scene = scene or _scene_of(env)
    view = LiveView(open_own(policy, env, seed), serve(host, port, names), scene=scene)
    try:
        view.run()
    except KeyboardInterrupt:
        pass  # the way to end it
    finally:
        view.close()


def _scene_of(env: gymnasium.Env[Any, Any]) -> MakeScene:
    """The scene of an environment that says itself what there is to see."""
    if not (hasattr(env.unwrapped, "model") and hasattr(env.unwrapped, "data")):
        raise ComparisonError(
            f"{type(env.unwrapped).__name__} has no MuJoCo model and data: name a scene, a class "
            "derived from PlaneScene of aicon_baselines.view"
        )
    from aicon_baselines.view.space import MuJoCoScene  # needs mujoco

    return MuJoCoScene
