import numpy as np
import pytest
import torch
from _inputs import lean
from _inputs.arm import HOME, camera_observation, panda

from aicon_torch import ObservationError
from aicon_torch.models.arm_push import PANDA, Options, camera_perception
from aicon_torch.models.arm_push.image_registration import Detection, ImageRegistration
from aicon_torch.models.arm_push.image_segmentation import RGBDImage

PERCEPTION = camera_perception(Options())


SEEN = Detection(np.array([0.55, 0.2, 0.3]), 0.04, 1.0, np.array([0.55, 0.2]))


class Found:
    """A registration that finds the object at a pose, and remembers what it was asked."""

    corners = np.array([[0.0, 0.0], [0.1, 0.0], [0.0, 0.1]])
    intrinsics = PANDA.intrinsics

    def __init__(self, score=1.0):
        self.score, self.images, self.priors = score, [], []

    def __call__(self, image, prior):
        self.images.append(image)
        self.priors.append(prior)
        return Detection(np.array([0.5, 0.1, 0.0]), 0.04, self.score, np.array([0.5, 0.12]))

    def placed(self, pose):
        return self.corners + pose[:2]


def with_registration(registration, monkeypatch):
    perception = camera_perception(Options())
    monkeypatch.setattr(perception, "registration", registration)
    return perception


def last_step(age=0.0):
    pose = torch.tensor([0.5, 0.0, 0.1], dtype=torch.float64)
    return {"z_age": torch.tensor([age]), "x_pose": pose}


def test_the_corners_are_told_in_the_frame_of_the_camera(monkeypatch):
    perception = with_registration(Found(), monkeypatch)
    readings = perception(camera_observation(), None, None)
    camera = perception.camera(HOME.numpy())
    corners = readings["z_keypoints"].reshape(3, 3) @ camera[:3, :3].T + camera[:3, 3]
    np.testing.assert_allclose(corners[1], [0.6, 0.1, 0.04], atol=1e-12)
    assert np.isnan(readings["z_blob"]).all()
    assert "rgb" not in readings and "depth" not in readings and "ft" in readings


def test_a_registration_that_fits_badly_leaves_the_middle_of_what_is_seen(monkeypatch):
    perception = with_registration(Found(score=0.5), monkeypatch)
    readings = perception(camera_observation(), None, None)
    camera = perception.camera(HOME.numpy())
    middle = camera[:3, :3] @ readings["z_blob"] + camera[:3, 3]
    np.testing.assert_allclose(middle, [0.5, 0.12, 0.04], atol=1e-12)
    assert np.isnan(readings["z_keypoints"]).all()


def test_the_search_begins_where_the_object_is_believed_to_be_unless_all_begins_anew(monkeypatch):
    found = Found()
    perception = with_registration(found, monkeypatch)
    perception(camera_observation(), None, None)
    perception(camera_observation(), last_step(), None)
    perception(camera_observation(), last_step(), np.array(True))
    assert found.priors[0] is None and found.priors[2] is None
    np.testing.assert_allclose(found.priors[1], [0.5, 0.0, 0.1])


def test_an_image_is_read_once(monkeypatch):
    found = Found()
    perception = with_registration(found, monkeypatch)
    for age, before, new in ((0.02, 0.01, False), (0.01, 0.04, True), (0.0, 0.0, True)):
        observation = camera_observation(image_age=np.array([age]))
        readings = perception(observation, last_step(before), None)
        assert np.isfinite(readings["z_keypoints"]).all() == new
    perception(camera_observation(image_age=np.array([0.02])), last_step(0.01), np.array(True))
    assert len(found.images) == 3


def test_an_old_image_was_taken_where_the_camera_was_then(monkeypatch):
    found = Found()
    perception = with_registration(found, monkeypatch)
    velocity = np.full(7, 0.2)
    perception(camera_observation(image_age=np.array([0.1]), dq=velocity), None, None)
    expected = perception.camera(HOME.numpy() - 0.1 * velocity)
    np.testing.assert_allclose(found.images[0].position, expected[:3, 3])


def test_where_the_joints_are_remembered_it_was_taken_where_they_were_then(monkeypatch):
    """In the last two steps; what is older was as it was two steps ago."""
    recent = torch.cat([HOME + 0.02, HOME + 0.01])
    for age, moved in ((0.0, 0.0), (0.01, 0.01), (0.02, 0.02), (0.3, 0.02)):
        found = Found()
        perception = with_registration(found, monkeypatch)
        values = last_step(age + 0.04) | {"z_joints_recent": recent}
        readings = perception(camera_observation(image_age=np.array([age])), values, None)
        expected = perception.camera(HOME.numpy() + moved)
        np.testing.assert_allclose(found.images[0].position, expected[:3, 3], atol=1e-12)
        assert readings["seen_age"] == [age]


def test_what_was_seen_some_steps_ago_is_older(monkeypatch):
    perception = with_registration(Found(), monkeypatch)
    observation = camera_observation(image_age=np.array([0.1]))
    see = perception.begin(observation, None, None)
    observation["image_age"][:] = 0.0
    readings = perception.readings(see(), observation, late=3)
    np.testing.assert_allclose(readings["seen_age"], [0.13])


def test_a_late_image_says_where_the_object_was(monkeypatch):
    """It is seen 0.1 s late where it lies, while the tip, which does not touch it, goes on."""
    monkeypatch.setattr(ImageRegistration, "__call__", lambda *_: SEEN)
    policy = lean("arm_push", **{"camera.delay": 10})
    memory = None
    for step in range(15):
        age = np.array([0.1 if step % 5 == 0 else 0.1 + 0.01 * (step % 5)])
        action, memory = policy.predict(camera_observation(image_age=age), memory)
    assert np.isfinite(action).all() and memory["x_pose_lag"] == 10
    np.testing.assert_allclose(memory["x_pose"], SEEN.pose, atol=5e-3)


def test_each_row_of_a_batch_has_an_image_of_its_own(monkeypatch):
    found = Found()
    perception = with_registration(found, monkeypatch)
    rows = {key: np.stack([value] * 2) for key, value in camera_observation().items()}
    rows["image_age"] = np.array([[0.02], [0.0]])
    values = {key: value.expand(2, -1) for key, value in last_step(0.01).items()}
    readings = perception(rows, values, None)
    assert np.isfinite(readings["z_keypoints"]).all(-1).tolist() == [False, True]
    assert len(found.images) == 1


@pytest.mark.parametrize("key", ["rgb", "depth", "image_age", "q", "dq"])
def test_what_is_missing_is_named(key):
    observation = camera_observation()
    del observation[key]
    with pytest.raises(ObservationError, match=f"has no '{key}'"):
        PERCEPTION(observation, None, None)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("rgb", np.zeros((3, 120, 160), np.uint8)),
        ("rgb", np.zeros((60, 80, 3), np.uint8)),
        ("depth", np.ones((120, 160, 1), np.float32)),
        ("image_age", 0.0),
        ("q", np.zeros(6)),
        ("dq", None),
    ],
)
def test_what_has_another_shape_is_named(key, value):
    with pytest.raises(ObservationError, match=f"'{key}': expected shape"):
        PERCEPTION({**camera_observation(), key: value}, None, None)


def test_colours_that_are_no_bytes_are_named():
    colours = np.ones((120, 160, 3), np.float32)
    with pytest.raises(ObservationError, match=r"'rgb': expected uint8, 0 to 255, got float32"):
        PERCEPTION({**camera_observation(), "rgb": colours}, None, None)


def test_unseen_the_object_becomes_uncertain_and_the_policy_goes_on():
    policy = lean("arm_push")
    _, memory = policy.predict(camera_observation())
    first = memory["P_pose"].diagonal().sum()
    for _ in range(5):
        action, memory = policy.predict(camera_observation(), memory)
    assert np.isfinite(action).all() and memory["P_pose"].diagonal().sum() > first


def test_a_rendered_object_is_found_within_2_mm():
    arm_push = pytest.importorskip("aicon_envs.arm_push")
    env = arm_push.ArmPushEnv()
    find = ImageRegistration(env.object.corners, PANDA.intrinsics)
    for seed in range(3):
        try:
            reading, info = env.reset(seed=seed)
        except RuntimeError:
            pytest.skip("no OpenGL without a display")

        camera = PERCEPTION.camera(reading["q"])
        image = RGBDImage(reading["rgb"], reading["depth"], camera[:3, :3], camera[:3, 3])
        found = find(image, info["object_pose"] + [0.005, -0.005, 0.05])

        assert np.linalg.norm(found.pose[:2] - info["object_pose"][:2]) < 0.002
        assert abs(found.pose[2] - info["object_pose"][2]) < 0.02
        assert found.height == pytest.approx(0.04, abs=2e-3)
    env.close()


def test_the_camera_of_the_perception_is_that_of_the_graph():
    policy = lean("arm_push")
    _, memory = policy.predict(camera_observation())
    expected = panda().chain.frames(memory["x_joints"])[-1].numpy() @ PERCEPTION.mount
    found = PERCEPTION.camera(memory["x_joints"].numpy())
    np.testing.assert_allclose(found, expected)
    np.testing.assert_allclose(memory["x_cam"][9:], expected[:3, 3], atol=1e-12)
