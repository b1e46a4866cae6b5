"""What a network sees in a picture is a measurement with variances of its own."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from _inputs.pushing import body_of, poses

from aicon_torch import ObservationError, OptionError, Policy, make_policy
from aicon_torch.models.pusht.picture import PoseNetwork
from aicon_torch.parts.planar import pose_error


@pytest.fixture
def weights(tmp_path: Path) -> Path:
    """Those of an untrained network."""
    torch.manual_seed(0)
    torch.save(PoseNetwork(body_of()).state_dict(), tmp_path / "weights.pt")
    return tmp_path / "weights.pt"


@pytest.fixture
def policy(weights: Path) -> Policy:
    """A policy whose network is untrained."""
    return make_policy("pusht", picture=weights, push_noise=0.2)


def seen(variance: float) -> dict[str, torch.Tensor]:
    """A pose, told with a variance."""
    told = torch.cat(
        (poses(1, seed=1), torch.full((1, 3), variance, dtype=torch.float64).log()), -1
    )
    return {"agent_pos": torch.tensor([[256.0, 400.0]]), "seen": told}


@pytest.mark.parametrize("side", [96, 48])
def test_a_picture_leads_to_an_action(policy: Policy, side: int) -> None:
    picture = np.full((2, side, side, 3), 255, np.uint8)
    observation = {"agent_pos": np.full((2, 2), 256.0), "pixels": picture}
    action, memory = policy.predict(observation)
    assert action.shape == (2, 2) and np.isfinite(action).all()
    assert memory["z_seen"].shape == (2, 6)


def moved_by(policy: Policy) -> list[float]:
    """By how much a pose follows one that is seen 1 cm beside it, clearly and not, m."""
    policy.perception = None
    _, memory = policy.predict(seen(1e-4))
    shifted = seen(1e-4)
    shifted["seen"][:, 0] += 0.01
    moved: list[float] = []
    for variance in (1e-8, 1e-2):
        shifted["seen"][:, 3:] = torch.full((3,), variance).log()
        _, after = policy.predict(shifted, memory)
        moved.append(float(after["x_pose"][0, 0] - memory["x_pose"][0, 0]))
    return moved


def test_what_is_seen_clearly_counts_more(policy: Policy) -> None:
    clearly, hardly = moved_by(policy)
    assert 0.009 < clearly <= 0.01 and 0 < hardly < 0.001


def test_with_a_noise_that_is_given_all_pictures_count_the_same(weights: Path) -> None:
    clearly, hardly = moved_by(make_policy("pusht", picture=weights, picture_noise=0.01))
    assert clearly == hardly == pytest.approx(0.01 / 3, rel=0.02)  # the third of three alike
    with pytest.raises(OptionError, match="picture_noise"):
        make_policy("pusht", picture=weights, picture_noise=0.0)


def test_without_estimation_what_is_seen_is_taken_as_it_comes(weights: Path) -> None:
    taken = make_policy("pusht", picture=weights, estimation=False)
    taken.perception, memory = None, None
    for variance in (1e-4, 1e-2):
        told = seen(variance)
        _, memory = taken.predict(told, memory)
        torch.testing.assert_close(memory["x_pose"], told["seen"][:, :3], rtol=0, atol=1e-6)


def test_a_corner_that_is_unsure_counts_less() -> None:
    body, true = body_of(), poses(4, seed=1)
    corners = body.keypoints_at(true)
    corners[:, 0] += 0.05
    sure = torch.ones(4, 8, dtype=torch.float64) / 8
    torch.testing.assert_close(body.registration(corners, sure), body.registration(corners))
    sure[:, 0], sure[:, 1:] = 0.0, 1 / 7
    off = pose_error(body.registration(corners, sure), true, 1.0)
    torch.testing.assert_close(off, torch.zeros_like(off))


def test_weights_of_something_else_are_an_error(tmp_path: Path) -> None:
    torch.save({"layer.weight": torch.zeros(2)}, tmp_path / "other.pt")
    torch.save(torch.zeros(2), tmp_path / "tensor.pt")
    (tmp_path / "empty.pt").touch()
    (tmp_path / "bytes.pt").write_bytes(bytes(range(256)))
    for name in ("other", "none", "tensor", "empty", "bytes"):
        path = tmp_path / f"{name}.pt"
        with pytest.raises(OptionError, match="no weights of such a network"):
            make_policy("pusht", picture=path)


WHITE = np.full((96, 96, 3), 255, np.uint8)


@pytest.mark.parametrize(
    "pixels",
    [None, "pixels", WHITE / 255.0, WHITE[..., 0], WHITE.transpose(2, 0, 1)],
    ids=["none", "a word", "shares", "grey", "colours first"],
)
def test_what_is_no_picture_is_named(policy: Policy, pixels: Any) -> None:
    seen = {"agent_pos": np.full(2, 256.0)}
    with pytest.raises(ObservationError, match="'pixels': expected pictures"):
        policy.predict({**seen, "pixels": pixels})
    with pytest.raises(ObservationError, match="no 'pixels' in the observation: 'agent_pos'"):
        policy.predict(seen)


def test_a_picture_that_is_a_view_is_seen_alike(policy: Policy) -> None:
    picture = np.random.default_rng(0).integers(0, 256, (96, 96, 3)).astype(np.uint8)
    seen = {"agent_pos": np.full(2, 256.0)}
    expected, _ = policy.predict({**seen, "pixels": picture})
    found, _ = policy.predict({**seen, "pixels": picture[::-1].copy()[::-1]})
    np.testing.assert_array_equal(found, expected)


def test_a_picture_is_prompt() -> None:
    with pytest.raises(OptionError, match="expected keypoint_offset=0 and delay=0"):
        make_policy("pusht", picture="weights.pt", delay=3)
