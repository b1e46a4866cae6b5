import math

import numpy as np
import torch
from _inputs.arm import HOME, panda_chain, postures

from aicon_torch.models.arm_push.robot import PANDA_FRAMES, PANDA_TOOL
from aicon_torch.parts.chain import Chain, Joint

IDENTITY = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0))
ONE_AHEAD = ((1.0, 0.0, 0.0, 1.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0))


def test_a_planar_arm_is_where_trigonometry_says():
    chain = Chain([IDENTITY, ONE_AHEAD], ONE_AHEAD)  # two links of one metre
    q = torch.tensor([0.3, 0.5], dtype=torch.float64)
    elbow, tip = chain.frames(q)[1, :3, 3], chain.frames(q)[2, :3, 3]
    torch.testing.assert_close(elbow.tolist(), [math.cos(0.3), math.sin(0.3), 0.0])
    expected = [math.cos(0.3) + math.cos(0.8), math.sin(0.3) + math.sin(0.8), 0.0]
    torch.testing.assert_close(tip.tolist(), expected)


def test_the_frames_are_the_product_of_all_transforms_before():
    q = postures(1)[0]
    frames = panda_chain().frames(q)
    expected = np.eye(4)
    for index, (fixed, angle) in enumerate(zip(PANDA_FRAMES, q.tolist(), strict=True)):
        turn = np.eye(4)
        turn[:2, :2] = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
        expected = expected @ np.vstack((fixed, [0.0, 0.0, 0.0, 1.0])) @ turn
        np.testing.assert_allclose(frames[index], expected, atol=1e-14)
    tool = np.vstack((PANDA_TOOL, [0.0, 0.0, 0.0, 1.0]))
    np.testing.assert_allclose(frames[7], expected @ tool, atol=1e-14)


def test_leading_dimensions_are_free_and_a_batch_is_its_rows():
    chain, q = panda_chain(), postures(6).reshape(2, 3, 7)
    together = chain.frames(q)
    assert together.shape == (2, 3, 8, 4, 4)
    for row in np.ndindex(2, 3):
        torch.testing.assert_close(together[row], chain.frames(q[row]))


def test_the_frames_can_be_differentiated():
    chain = panda_chain()
    torch.autograd.gradcheck(lambda q: chain.frames(q)[..., :3, 3], HOME.clone().requires_grad_())


def test_a_fourth_row_of_a_transform_is_left_out():
    whole = (*ONE_AHEAD, (0.0, 0.0, 0.0, 1.0))
    q = torch.tensor([0.3, 0.5])
    with_it, without = Chain([whole, whole], whole), Chain([ONE_AHEAD, ONE_AHEAD], ONE_AHEAD)
    torch.testing.assert_close(with_it.frames(q), without.frames(q))


def test_random_postures_fill_the_ranges_and_half_a_turn_to_both_sides_without():
    joints = [Joint("beyond", low=1.0, high=5.0), Joint("free")]
    q = Chain([IDENTITY, ONE_AHEAD], ONE_AHEAD, joints).postures(4096)
    ends = torch.tensor([[1.0, 5.0], [-math.pi, math.pi]], dtype=torch.float64)
    torch.testing.assert_close(torch.stack((q.amin(0), q.amax(0)), -1), ends, atol=0.02, rtol=0.0)
