"""An episode of pushing and all that the policy knew in it."""

from functools import cached_property
from typing import Any, ClassVar

import gymnasium
import numpy as np
import torch
from torch import Tensor

from aicon_baselines.evaluation import recording
from aicon_baselines.evaluation.recording import BoolArray, FloatArray, Recording, to_array
from aicon_envs.pusht.geometry import place
from aicon_envs.pusht.simulation import PUSHER_RADIUS
from aicon_torch.models.pusht import PIXEL
from aicon_torch.parts import Servo
from aicon_torch.policy import Policy

_CORNER = 1.0  # px from a corner within which a contact is at it
_NEAR = 10.0  # px between pusher and object within which a contact is at stake


class PushRecording(Recording):
    """An episode of n steps, seen at the n + 1 moments before, between and after them.

    The last memory was computed after the end, and its action was not carried out. The figure shows
    the gradients at the pusher's position, one for each of the N sides that may be touched.
    Lengths are in the environment's pixels.
    """

    resolved_at: ClassVar[str] = "x_pusher"

    @property
    def outline(self) -> FloatArray:
        """Corners of the object in its body frame, in order around it, (N, 2), px."""
        outline: FloatArray = self.env.object.outline
        return outline

    @property
    def goal(self) -> FloatArray:
        """Pose of the goal, px and rad."""
        goal: FloatArray = self.told("goal_pose")[-1]
        return goal

    @cached_property
    def pushers(self) -> FloatArray:
        """True positions of the pusher, (n + 1, 2), px."""
        return self.told("pos_agent")

    @cached_property
    def velocities(self) -> FloatArray:
        """True velocities of the pusher, (n + 1, 2), px/s."""
        return self.told("vel_agent")

    @cached_property
    def poses(self) -> FloatArray:
        """True poses of the object's body frame, (n + 1, 3), px and rad."""
        return self.told("block_pose")

    @cached_property
    def touched(self) -> BoolArray:
        """Whether anything touched in the step that led to the moment, (n + 1,)."""
        return self.told("n_contacts") > 0

    @property
    def steps(self) -> int:
        """Number of steps n."""
        return len(self.memories) - 1

    @cached_property
    def trajectory(self) -> FloatArray:
        """Where the pusher was at the start and in the k sub-steps of each step, (n, k + 1, 2), px.

        The environment tells where it was at the moments; between them it follows its controller.
        """
        servo = Servo.of()
        by_offset = np.array([0.0, *servo.displacement_by_offset])[:, np.newaxis]
        by_velocity = np.array([0.0, *servo.displacement_by_velocity])[:, np.newaxis]

        # Without an offset of the target the pusher only drifts.
        start, end = self.pushers[:-1, np.newaxis], self.pushers[1:, np.newaxis]
        drifted = by_velocity * self.velocities[:-1, np.newaxis]
        followed = end - start - drifted[:, -1:]

        trajectory: FloatArray = start + drifted + by_offset / by_offset[-1] * followed
        return trajectory

    @cached_property
    def costs(self) -> FloatArray:
        """The pose error g as the policy estimates it, (n + 1,), px."""
        return _in_pixels(self.trace.costs["push"])

    @cached_property
    def gains(self) -> FloatArray:
        """By how much g would change for each unit of likelihood of each contact, (n + 1, N), px.

        A contact with a gain below zero is useful; the policy seeks it. The others are detrimental.
        """
        model = self.policy.model
        likelihood = self.trace.values["p_contact"].detach().requires_grad_()
        values: dict[str, Any] = {**self.trace.values, "p_contact": likelihood}

        # The two edges from the likelihood to the goal, in one graph.
        with torch.enable_grad():
            values["x_obj"] = model.owners["x_obj"](values, "x_obj")
            cost = model.goals["push"](values).sum()
        (gains,) = torch.autograd.grad(cost, likelihood)

        # Of the two likelihoods of a contact one counts: the other's derivative is zero.
        return _in_pixels(gains.sum(-1))

    @cached_property
    def useful(self) -> BoolArray:
        """Which contacts are useful, (n + 1, N)."""
        return self.gains < 0

    @cached_property
    def contacts(self) -> FloatArray:
        """The closest point of each side, (n + 1, N, 2), px."""
        return _in_pixels(self.trace.values["x_contact"])

    @cached_property
    def likelihoods(self) -> FloatArray:
        """Likelihood of each contact, intended if it is useful and incidental if not, (n + 1, N).

        Those of contacts that are intended exceed 1 where the pusher is nearer than at a touch;
        here they end at 1.
        """
        intended, incidental = np.moveaxis(to_array(self.trace.values["p_contact"]), -1, 0)
        likelihoods: FloatArray = np.minimum(np.where(self.useful, intended, incidental), 1.0)
        return likelihoods

    @cached_property
    def descents(self) -> FloatArray:
        """−∇ of each contact at the pusher, (n + 1, N, 2), px of g by px of the pusher."""
        return -to_array(self.resolution.gradients)

    @cached_property
    def strengths(self) -> FloatArray:
        """Norms of the gradients, (n + 1, N)."""
        return to_array(self.resolution.magnitudes)

    def strongest(self, useful: bool) -> FloatArray:
        """Strength of the strongest gradient of useful or detrimental contacts, (n + 1,).

        It is 0 where there is no such contact.
        """
        strongest: FloatArray = np.where(self.useful == useful, self.strengths, 0.0).max(axis=1)
        return strongest

    @cached_property
    def motions(self) -> FloatArray:
        """Commanded displacement of the pusher in the step after each moment, (n + 1, 2), px."""
        return _in_pixels(self.trace.values["a"]) * self.time_step

    @cached_property
    def at_corners(self) -> BoolArray:
        """Whether it is near the object and its nearest contact is at a corner, (n + 1,)."""
        distances = np.linalg.norm(self.contacts - self.pushers[:, np.newaxis], axis=-1)
        moments = range(len(distances))
        nearest = self.contacts[moments, distances.argmin(axis=1)]

        corners = np.stack([self.corners(moment) for moment in moments])
        to_corners = np.linalg.norm(corners - nearest[:, np.newaxis], axis=-1)

        # Far from the object no contact is at stake.
        near_corner = to_corners.min(axis=1) < _CORNER
        near_object = distances.min(axis=1) < PUSHER_RADIUS + _NEAR
        at_corners: BoolArray = near_corner & near_object
        return at_corners

    def corners(self, moment: int) -> FloatArray:
        """Corners of the object in the world, in order around it, (N, 2), px."""
        x, y, angle = self.poses[moment]
        return place(self.outline, (x, y, angle))


def _in_pixels(lengths: Tensor) -> FloatArray:
    """Lengths of the model, m, in the environment's pixels."""
    return to_array(lengths) / PIXEL


def record(policy: Policy, seed: int, limit: int | None = None) -> PushRecording:
    """Run an episode of aicon/PushT-v0 and keep the memory of every moment.

    Args:
        policy: A pushing policy.
        seed: Seed of the episode.
        limit: Limit of the episode, steps; by default the environment's.
    """
    env = gymnasium.make("aicon/PushT-v0", max_episode_steps=limit)
    return recording.record(PushRecording, policy, env, {"seed": seed}, beyond=True)
