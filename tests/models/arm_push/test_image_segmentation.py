import numpy as np
from _inputs.images import BLACK, GREY, INTRINSICS, L_SHAPE, RED, TOP, behind_stick, from_above

from aicon_torch.models.arm_push.image_segmentation import (
    TopFaceSegmentation,
    close,
    dilate,
    is_colored,
    thin,
)
from aicon_torch.models.arm_push.polygon import contains, place, signed_distance

POSE = np.array([0.02, -0.01, 0.4])
SEGMENT = TopFaceSegmentation(INTRINSICS)
PIXEL = (0.35 - TOP) / INTRINSICS.focal  # size of a pixel on the top face, m


def test_the_face_is_inside_the_outline_and_its_edges_are_on_it():
    face = SEGMENT(from_above(POSE))
    corners = place(L_SHAPE, POSE)
    assert contains(face.surface, corners, PIXEL).all()
    distance, _ = signed_distance(face.edges, corners)
    assert np.abs(distance).max() < PIXEL
    np.testing.assert_allclose(face.height, TOP, atol=1e-4)


def test_noise_of_the_depth_does_not_move_the_height_of_the_face():
    face = SEGMENT(from_above(POSE, noise=0.003))
    np.testing.assert_allclose(face.height, TOP, atol=2e-3)


def test_what_a_stick_hides_is_no_edge():
    image = from_above(POSE)
    face = SEGMENT(behind_stick(image))
    distance, _ = signed_distance(face.edges, place(L_SHAPE, POSE))
    assert np.abs(distance).max() < PIXEL
    assert len(face.surface) < len(SEGMENT(image).surface)
    assert face.hidden.any() and not SEGMENT(image).hidden.any()


def test_the_border_of_the_image_is_no_edge():
    pose = np.array([0.28, 0.0, 0.4])  # half of it out of view
    distance, _ = signed_distance(SEGMENT(from_above(pose)).edges, place(L_SHAPE, pose))
    assert np.abs(distance).max() < PIXEL


def test_an_image_without_an_object_shows_nothing():
    assert SEGMENT(from_above(np.array([5.0, 0.0, 0.0]))) is None
    assert SEGMENT(from_above(np.array([0.36, 0.0, 0.0]))) is None  # a sliver of it


def test_red_and_blue_are_colours_and_grey_and_black_are_not():
    colors = np.array([RED, RED[::-1], GREY, BLACK], dtype=np.uint8)
    assert is_colored(colors).tolist() == [True, True, False, False]


def test_a_hole_of_one_pixel_is_closed():
    mask = np.zeros((9, 9), np.bool_)
    mask[2:7, 2:7] = True
    whole = mask.copy()
    mask[4, 4] = False
    assert (close(mask) == whole).all()
    assert dilate(whole).sum() == 25 + 20


def test_thinning_keeps_about_as_many_as_asked_for():
    points = np.zeros((1000, 2))
    assert 150 <= len(thin(points, 150)) < 300
    assert len(thin(points[:10], 150)) == 10
