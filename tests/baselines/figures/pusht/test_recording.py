"""What the pushing figure shows is what happened and what the policy knew, in pixels."""

import numpy as np

from aicon_baselines.figures.pusht import PushRecording
from aicon_envs.pusht.simulation import SUB_STEP
from aicon_torch.models.pusht import PIXEL, Options, rigid_object
from aicon_torch.parts import ContactDynamics, inward_normal


def test_beliefs_are_where_the_world_is(episode: PushRecording) -> None:
    believed = episode.trace.values["x_pusher"].numpy() / PIXEL
    np.testing.assert_allclose(believed, episode.pushers, atol=1.0)

    sides = episode.trace.values["x_side"].numpy() / PIXEL
    for moment, starts in enumerate(sides[..., :2]):
        offsets = starts[:, np.newaxis] - episode.corners(moment)
        assert np.linalg.norm(offsets, axis=-1).min(axis=1).max() < 1.0


def test_useful_contacts_are_those_that_lower_the_cost(episode: PushRecording) -> None:
    body = rigid_object(Options())
    length = 1.55 * body.radius_of_gyration
    dynamics = ContactDynamics(body, rotation_length=length, step=1 * PIXEL)
    weights = np.array([1.0, 1.0, length])

    values = episode.trace.values
    normals = inward_normal(values["x_side"])
    effects = dynamics.effects(values["x_obj"], values["x_contact"], normals).numpy()

    error = (values["x_obj"] - values["x_target"]).numpy()
    error[:, 2] = (error[:, 2] + np.pi) % (2 * np.pi) - np.pi
    cost = np.linalg.norm(weights * error, axis=1)
    gains = np.einsum("nsi,ni->ns", effects, weights**2 * error) / cost[:, np.newaxis]

    np.testing.assert_allclose(episode.costs, cost / PIXEL, rtol=1e-9)
    np.testing.assert_allclose(episode.gains, dynamics.step * gains / PIXEL, atol=1e-9)
    assert (episode.useful == (gains < 0)).all()


def test_strengths_are_those_of_the_descents(episode: PushRecording) -> None:
    norms = np.linalg.norm(episode.descents, axis=-1)
    np.testing.assert_allclose(episode.strengths, norms, rtol=1e-12)


def test_trajectory_between_the_moments_is_the_controllers(episode: PushRecording) -> None:
    trajectory = episode.trajectory
    np.testing.assert_allclose(trajectory[:, 0], episode.pushers[:-1])
    np.testing.assert_allclose(trajectory[:, -1], episode.pushers[1:])

    speeds = np.diff(trajectory, axis=1)[:, -1] / SUB_STEP
    np.testing.assert_allclose(speeds, episode.velocities[1:], atol=1e-2)  # targets are float32
