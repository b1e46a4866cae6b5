"""Where the object is in a picture: a small network that says also how sure it is.

One heatmap for each corner of the object; where it is, is the mean of the softmax of its heatmap
(soft-argmax). The rigid object that fits these corners best has the pose, and what is left of them
and what the picture shows tell the variances, with which the pose is a measurement like any other.
"""

import pickle
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from aicon_torch.errors import ObservationError, OptionError, choices
from aicon_torch.models.pusht.benchmark import WORKSPACE
from aicon_torch.parts.planar import norm, pose_error
from aicon_torch.parts.rigid_object import RigidObject

CHANNELS = 28
DILATIONS = (1, 2, 4, 8)
"""Of the convolutions at a quarter of the picture's size: they see 15 cells in each direction."""

MARGIN = 1
"""Cells of a heatmap beyond each border of the picture: a corner may be at the border."""

SEEN = 6
"""Numbers of what is seen: the pose, m and rad, and the logarithms of its variances."""

TYPICAL = (-7.0, -7.0, -3.0)
"""Logarithms of variances with which training starts, m² and rad²: 30 px and 13°."""


class Sight(NamedTuple):
    """What a network sees in pictures.

    Attributes:
        pose: Of the object, and the logarithms of its variances, ``(B, 6)``, m and rad.
        corners: Of the object, ``(B, K, 2)``, m.
        log_variances: Of the corners' coordinates, ``(B, K)``, m².
        log_share: Where each corner may be, log-probabilities of cells, ``(B, K, h, w)``.
    """

    pose: Tensor
    corners: Tensor
    log_variances: Tensor
    log_share: Tensor


class PoseNetwork(nn.Module):
    """The pose of an object in a picture, and the logarithms of its variances.

    Args:
        body: The object.
    """

    def __init__(self, body: RigidObject) -> None:
        super().__init__()
        self.body, corners = body, len(body.keypoints)

        # Halved twice, so that a heatmap has a cell for four by four px of the picture.
        layers: list[nn.Module] = [
            *(nn.Conv2d(3, 16, 3, stride=2, padding=1), nn.ReLU()),
            *(nn.Conv2d(16, CHANNELS, 3, stride=2, padding=1), nn.ReLU()),
        ]
        for dilation in DILATIONS:
            convolution = nn.Conv2d(CHANNELS, CHANNELS, 3, padding=dilation, dilation=dilation)
            layers += [convolution, nn.ReLU()]
        self.features = nn.Sequential(*layers)

        # For each corner a map of where it is, and one of how unsure that looks.
        self.heatmaps = nn.Conv2d(CHANNELS, 2 * corners, 3, padding=1 + MARGIN)

        # The features, pooled in two ways, and three numbers for each corner tell the variances.
        told = 2 * CHANNELS + 3 * corners
        self.variances = nn.Sequential(nn.Linear(told, 24), nn.ReLU(), nn.Linear(24, 3))

    def forward(self, picture: Tensor) -> Sight:
        """What is seen in pictures ``(B, 3, h, w)``, 0 to 1."""
        return self.seen_in(self.features(picture - 0.5))

    def seen_in(self, features: Tensor) -> Sight:
        """What is seen in the features ``(B, c, h / 4, w / 4)`` of pictures."""
        heat, doubt = self.heatmaps(features).chunk(2, dim=-3)

        # Each corner is where its heatmap has its mean, and as unsure as it looks there.
        log_share = heat.flatten(-2).log_softmax(-1)
        share, places = log_share.exp(), _places(heat)
        corners = share @ places
        log_variances = (share * doubt.flatten(-2)).sum(-1) + TYPICAL[0]

        # The pose fits best the corners that are seen best.
        pose = self.body.registration(corners, (-log_variances).softmax(-1))
        off = norm(corners - self.body.keypoints_at(pose))
        spread = (share @ places.square() - corners.square()).sum(-1).clamp(min=1e-12).sqrt()

        # What its own variances are is told by how its corners agree.
        pooled = (features.mean((-2, -1)), features.amax((-2, -1)))
        told = torch.cat((*pooled, 100 * off, 100 * spread, log_variances - TYPICAL[0]), dim=-1)
        variances = self.variances(told) + told.new_tensor(TYPICAL)
        seen = torch.cat((pose, variances), dim=-1)
        return Sight(seen, corners, log_variances, log_share.unflatten(-1, heat.shape[-2:]))


def seen_off(x_pose: Tensor, z_seen: Tensor) -> Tensor:
    """The residual ``(*B, 3)`` of a pose and of what is seen ``(*B, 6)``, m and rad."""
    return pose_error(x_pose, z_seen[..., :3])


def seen_variances(z_seen: Tensor) -> Tensor:
    """The variances ``(*B, 3)`` of the pose that is seen, m² and rad²."""
    return z_seen[..., 3:].exp()


def first_sight(z_seen: Tensor) -> tuple[Tensor, Tensor]:
    """The pose at first and its covariance, as it is seen: wide where that is unsure."""
    return z_seen[..., :3], torch.diag_embed(seen_variances(z_seen))


def along(cells: int, like: Tensor) -> Tensor:
    """Where the centres of the cells of a heatmap are along one axis, ``(cells,)``, m."""
    # The picture shows the workspace; the cells of the margin lie beyond it.
    low, high = WORKSPACE
    size = (high - low) / (cells - 2 * MARGIN)
    return low + size * (torch.arange(cells).to(like) - MARGIN + 0.5)


def _places(maps: Tensor) -> Tensor:
    """Where the cells of heatmaps ``(B, K, h, w)`` are in the world, ``(h w, 2)``, m."""
    height, width = maps.shape[-2:]
    x, y = along(width, maps), along(height, maps)
    return torch.stack(torch.meshgrid(x, y, indexing="xy"), -1).flatten(0, 1)


class PicturePerception:
    """What a :class:`PoseNetwork` sees in ``pixels``, as the reading ``seen``.

    Args:
        network: The network.
    """

    def __init__(self, network: PoseNetwork) -> None:
        self.network = network.eval()

    @classmethod
    def load(cls, path: str | Path, body: RigidObject) -> "PicturePerception":
        """With trained weights.

        Raises:
            OptionError: If the file is none of such a network.
        """
        network = PoseNetwork(body)
        try:
            weights = torch.load(Path(path), map_location="cpu", weights_only=True)
            network.load_state_dict(weights)
        except (
            *(OSError, EOFError, pickle.UnpicklingError),  # no file, or none of tensors
            *(RuntimeError, KeyError, ValueError, TypeError),  # or of others
        ) as error:
            raise OptionError(
                f"picture={str(path)!r}: no weights of such a network. {error}"
            ) from error
        return cls(network)

    @torch.no_grad()
    def __call__(
        self,
        observation: Mapping[str, Any],
        values: Mapping[str, Tensor] | None,
        starts: NDArray[np.bool_] | None,
    ) -> Mapping[str, Any]:
        """The observation with ``seen`` ``(*B, 6)`` in place of ``pixels`` ``(*B, h, w, 3)``.

        Raises:
            ObservationError: If there are no pixels, or they are no pictures.
        """
        if "pixels" not in observation:
            raise ObservationError(f"no 'pixels' in the observation: {choices(observation)}.")
        pixels = np.ascontiguousarray(observation["pixels"])
        if pixels.dtype != np.uint8 or pixels.ndim < 3 or pixels.shape[-1] != 3:
            raise ObservationError(
                "'pixels': expected pictures (*batch, height, width, 3) of uint8, 0 to 255, got "
                f"{pixels.dtype} {pixels.shape}."
            )
        pictures = torch.as_tensor(pixels)
        batch = pictures.shape[:-3]

        # Observations have colours last, from 0 to 255, networks first, from 0 to 1.
        flat = pictures.reshape(-1, *pictures.shape[-3:]).movedim(-1, -3)
        seen = self.network(flat.float() / 255).pose
        told = {name: value for name, value in observation.items() if name != "pixels"}
        return {**told, "seen": seen.reshape(*batch, SEEN).double().numpy()}
