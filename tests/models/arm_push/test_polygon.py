import numpy as np
import pytest
import torch
from _inputs.images import L_SHAPE

from aicon_torch.models.arm_push.polygon import contains, place, signed_distance
from aicon_torch.parts.rigid_object import RigidObject

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])  # counterclockwise


def test_points_are_inside_or_outside():
    points = np.array([[0.5, 0.5], [1.5, 0.5], [0.5, -0.1], [-0.1, 1.0]])
    assert contains(points, SQUARE, 0.0).tolist() == [True, False, False, False]


def test_a_margin_lets_points_be_outside_and_a_negative_one_keeps_them_inside():
    points = np.array([[1.05, 0.5], [0.95, 0.5], [1.2, 0.5]])
    assert contains(points, SQUARE, 0.1).tolist() == [True, True, False]
    assert contains(points, SQUARE, -0.1).tolist() == [False, False, False]
    assert contains(np.array([[0.5, 0.5]]), SQUARE, -0.1).all()


def test_the_inside_of_a_shape_that_is_not_convex_is_found():
    points = np.array([[-0.02, 0.05], [0.03, 0.05], [0.05, -0.05]])
    assert contains(points, L_SHAPE, 0.0).tolist() == [True, False, True]


@pytest.mark.parametrize("turned", [False, True])
def test_either_sense_of_the_corners_will_do_to_be_inside(turned):
    corners = SQUARE[::-1] if turned else SQUARE
    assert contains(np.array([[0.5, 0.5]]), corners, 0.0).all()


def test_the_distance_is_positive_on_the_right_of_a_side():
    points = np.array([[0.5, -0.2], [0.5, 0.1], [1.3, 0.5]])
    distance, normal = signed_distance(points, SQUARE)
    np.testing.assert_allclose(distance, [0.2, -0.1, 0.3], atol=1e-12)
    np.testing.assert_allclose(normal, [[0.0, -1.0], [0.0, -1.0], [1.0, 0.0]], atol=1e-12)


def test_a_polygon_is_placed_as_a_rigid_object_is():
    pose = np.array([0.3, -0.2, 0.7])
    body = RigidObject.of(L_SHAPE.tolist())
    expected = body.keypoints_at(body.pose_of_frame(torch.tensor(pose)))
    np.testing.assert_allclose(place(L_SHAPE, pose), expected, atol=1e-12)


def test_many_polygons_at_once_are_as_one_after_the_other():
    poses = np.array([[0.0, 0.0, 0.0], [0.02, -0.03, 1.0], [0.3, 0.1, -2.0]])
    points = np.random.default_rng(0).normal(scale=0.1, size=(20, 2))
    distances, normals = signed_distance(points, place(L_SHAPE, poses))
    inside = contains(points, place(L_SHAPE, poses), 0.01)

    for row, pose in enumerate(poses):
        distance, normal = signed_distance(points, place(L_SHAPE, pose))
        np.testing.assert_array_equal(distances[row], distance)
        np.testing.assert_array_equal(normals[row], normal)
        np.testing.assert_array_equal(inside[row], contains(points, place(L_SHAPE, pose), 0.01))
