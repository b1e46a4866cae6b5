"""An episode in one of other people's worlds, step by step."""

from collections.abc import Iterator
from importlib import import_module
from typing import Any, NamedTuple


class Moment(NamedTuple):
    """What is there at a step: before the action, or at the end.

    Attributes:
        world: The world itself.
        observation: What is seen, of a batch of one.
        info: What the world tells beside that.
        policy: The policy.
        memory: What it made of what is seen; at the end, what it made of the step before.
        is_last: Whether it is the end.
    """

    world: Any
    observation: Any
    info: Any
    policy: Any
    memory: Any
    is_last: bool = False


def moments(task_name: str, condition: str, seed: int, policy: Any = None) -> Iterator[Moment]:
    """Every step of an episode in a task MODULE:TASK, of the shipped policy, or of another one."""
    module, name = task_name.split(":")
    world = import_module(module)
    task = getattr(world, name)
    env = task.make_env(1, condition, task.horizon)
    if policy is None:
        policy = world.build(world.Options(**task.policy_options(condition))).compile()

    (observation, info), memory, ended = env.reset(seed=[seed]), None, False
    scene = env.envs[0].unwrapped.world
    while not ended:
        action, memory = policy.predict(observation, memory)
        yield Moment(scene, observation, info, policy, memory)
        observation, _, arrived, late, info = env.step(action)
        ended = bool((arrived | late).all())
    yield Moment(scene, observation, info, policy, memory, is_last=True)
    env.close()
