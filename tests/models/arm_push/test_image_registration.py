import numpy as np
import pytest
from _inputs.images import INTRINSICS, L_SHAPE, TOP, behind_stick, from_above

from aicon_torch.models.arm_push.image_registration import ImageRegistration

FIND = ImageRegistration(L_SHAPE, INTRINSICS)
POSE = np.array([0.02, -0.01, 0.4])


def assert_found(found, pose):
    np.testing.assert_allclose(found.pose[:2], pose[:2], atol=0.002)
    difference = np.remainder(found.pose[2] - pose[2] + np.pi, 2 * np.pi) - np.pi
    assert abs(difference) < 0.03
    assert found.height == pytest.approx(TOP, abs=1e-3)


def test_from_where_it_is_expected_the_object_is_found():
    found = FIND(from_above(POSE), POSE + np.array([0.01, -0.01, 0.15]))
    assert_found(found, POSE)
    assert found.score > 0.9


@pytest.mark.parametrize("angle", [-2.5, -0.8, 0.0, 1.3, 3.0])
def test_without_an_expectation_all_orientations_are_searched(angle):
    pose = np.array([-0.03, 0.02, angle])
    assert_found(FIND(from_above(pose), None), pose)


def test_a_wrong_expectation_is_given_up():
    assert_found(FIND(from_above(POSE), POSE + np.array([0.05, 0.0, 2.5])), POSE)


def test_behind_a_stick_it_is_found_as_well():
    found = FIND(behind_stick(from_above(POSE)), POSE + np.array([0.005, -0.005, 0.05]))
    assert_found(found, POSE)


def test_another_shape_fits_badly():
    triangle = np.array([[-0.08, -0.05], [0.08, -0.05], [0.0, 0.11]])
    found = FIND(from_above(POSE, corners=triangle), None)
    assert found.score < 0.75


def test_the_middle_of_what_is_seen_is_told():
    found = FIND(from_above(POSE), None)
    assert np.linalg.norm(found.middle - POSE[:2]) < 0.03


def test_where_there_is_no_object_none_is_found():
    assert FIND(from_above(np.array([5.0, 0.0, 0.0])), POSE) is None


def test_the_samples_are_well_inside_the_outline():
    assert len(FIND.samples) > 20
    assert (np.abs(FIND.samples) < 0.08).all()
