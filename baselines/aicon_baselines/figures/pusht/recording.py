"""An episode of pushing and all that the policy knew in it."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import gymnasium
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from aicon_envs.pusht.geometry import Pose, place
from aicon_torch.parts.servo import Servo
from aicon_torch.control import Policy
from aicon_torch.resolution import Memory

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

MEETING = "x_pusher"
"""The quantity where the gradients of all contacts meet: the pusher's position."""


@dataclass(frozen=True)
class Recording:
    """An episode of n steps, seen at the n + 1 moments before, between and after them.

    Attributes:
        seed: Seed of the episode.
        policy: The policy.
        memories: The memory of each moment; the last one was computed after the end, and not followed.
        outline: Corners of the object in its body frame, in order around it, (N, 2), px.
        goal: Pose of the goal, px and rad.
        pushers: True positions of the pusher, (n + 1, 2), px.
        velocities: True velocities of the pusher, (n + 1, 2), px/s.
        poses: True poses of the object's body frame, (n + 1, 3), px and rad.
        touched: Whether anything touched in the step that led to the moment, (n + 1,).
        ending: How the episode ended.
    """

    seed: int
    policy: Policy
    memories: list[Memory]
    outline: FloatArray
    goal: Pose
    pushers: FloatArray
    velocities: FloatArray
    poses: FloatArray
    touched: BoolArray
    ending: Literal["arrival", "time limit"]

    @property
    def steps(self) -> int:
        """Number of steps n."""
        return len(self.memories) - 1

    @cached_property
    def times(self) -> FloatArray:
        """When each moment was, (n + 1,), s."""
        return np.arange(self.steps + 1, dtype=np.float64) * self.policy.model.dt

    @cached_property
    def ways(self) -> FloatArray:
        """Where the pusher was in the m sub-steps of each step and just before them, (n, m + 1, 2), px.

        The environment tells where it was at the moments; between them it follows its PD controller.
        """
        servo = Servo.of()
        share = np.concatenate([[0.0], servo.follow])[:, np.newaxis]
        drift = np.concatenate([[0.0], servo.drift])[:, np.newaxis] * self.velocities[:-1, np.newaxis]
        start, end = self.pushers[:-1, np.newaxis], self.pushers[1:, np.newaxis]
        ways: FloatArray = start + drift + share / share[-1] * (end - start - drift[:, -1:])
        return ways

    @cached_property
    def costs(self) -> FloatArray:
        """The pose error g as the policy estimates it, (n + 1,), px."""
        return _array(self._cost(self._values))

    @cached_property
    def gains(self) -> FloatArray:
        """By how much g would change for each unit of likelihood of each contact, (n + 1, N), px.

        A contact with a gain below zero is useful; the policy seeks it. The others are detrimental.
        """
        likelihood = self._values["p_contact"].detach().requires_grad_()
        values = self._values | {"p_contact": likelihood}
        with torch.enable_grad():
            moved = self.policy.model.owners["x_obj"](values, "x_obj")
            (gains,) = torch.autograd.grad(self._cost(values | {"x_obj": moved}).sum(), likelihood)
        return _array(gains.sum(-1))  # one of the two likelihoods counts: the other's derivative is zero

    @cached_property
    def useful(self) -> BoolArray:
        """Which contacts are useful, (n + 1, N)."""
        return self.gains < 0

    @cached_property
    def contacts(self) -> FloatArray:
        """The closest point of each side, (n + 1, N, 2), px."""
        return _array(self._values["x_contact"])

    @cached_property
    def likelihoods(self) -> FloatArray:
        """Likelihood of each contact, as one that is sought if it is useful and as one that happens if not, (n + 1, N).

        Those of contacts that are sought exceed 1 where the pusher is nearer than at a touch; here they end at 1.
        """
        sought, happens = np.moveaxis(_array(self._values["p_contact"]), -1, 0)
        likelihoods: FloatArray = np.minimum(np.where(self.useful, sought, happens), 1.0)
        return likelihoods

    @cached_property
    def descents(self) -> FloatArray:
        """−∇ of each contact at the pusher, (n + 1, N, 2), px of g by px of the pusher."""
        return -_array(self._values[f"{MEETING}/gradients"])

    @cached_property
    def strengths(self) -> FloatArray:
        """Norms of the gradients, (n + 1, N)."""
        norms: FloatArray = np.linalg.norm(self.descents, axis=-1)
        return norms

    def strongest(self, useful: bool) -> FloatArray:
        """Strength of the strongest gradient of the useful or the detrimental contacts, (n + 1,); 0 without any."""
        strongest: FloatArray = np.where(self.useful == useful, self.strengths, 0.0).max(axis=1)
        return strongest

    @cached_property
    def motions(self) -> FloatArray:
        """Commanded displacement of the pusher in the step that follows each moment, (n + 1, 2), px."""
        return _array(self._values["a"]) * self.policy.model.dt

    @cached_property
    def exploring(self) -> BoolArray:
        """Whether each moment explores, (n + 1,)."""
        return np.array([bool(memory.get(f"{MEETING}/exploring", False)) for memory in self.memories])

    def corners(self, moment: int) -> FloatArray:
        """Corners of the object in the world, in order around it, (N, 2), px."""
        x, y, angle = self.poses[moment]
        return place(self.outline, (x, y, angle))

    @cached_property
    def _values(self) -> dict[str, Tensor]:
        """All memories as one batch."""
        return {key: torch.stack([memory[key] for memory in self.memories]) for key in self.memories[0]}

    def _cost(self, values: dict[str, Tensor]) -> Tensor:
        cost: Tensor = self.policy.model.goals["push"](values)
        return cost


def _array(tensor: Tensor) -> FloatArray:
    return tensor.numpy(force=True).astype(np.float64)


def record(policy: Policy, seed: int, limit: int | None = None) -> Recording:
    """Run an episode of aicon/PushT-v0 and keep the memory of every moment.

    Args:
        policy: A pushing policy.
        seed: Seed of the episode.
        limit: Limit of the episode, steps; by default the environment's.
    """
    env = gymnasium.make("aicon/PushT-v0", max_episode_steps=limit)
    observation, info = env.reset(seed=seed)
    action, memory = policy.predict(observation)
    memories, infos = [memory], [info]
    terminated = truncated = False
    while not (terminated or truncated):
        observation, _, terminated, truncated, info = env.step(action)
        action, memory = policy.predict(observation, memory)
        memories.append(memory)
        infos.append(info)
    base: Any = env.unwrapped
    env.close()
    return Recording(
        seed,
        policy,
        memories,
        outline=base.object.outline,
        goal=tuple(info["goal_pose"].tolist()),
        pushers=np.array([each["pos_agent"] for each in infos]),
        velocities=np.array([each["vel_agent"] for each in infos]),
        poses=np.array([each["block_pose"] for each in infos]),
        touched=np.array([each["n_contacts"] > 0 for each in infos]),
        ending="arrival" if info["is_success"] else "time limit",
    )
