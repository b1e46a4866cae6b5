"""Where the object is in a picture: a small network that says also how sure it is.

One heatmap for each corner of the object; where it is, is the mean of the softmax of its heatmap
(soft-argmax). The rigid object that fits these corners best has the pose, and what is left of them
and what the picture shows tell the variances, with which the pose is a measurement like any other.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from aicon_torch.errors import OptionError
from aicon_torch.models.pusht.benchmark import WORKSPACE
from aicon_torch.parts.planar import norm, pose_error
from aicon_torch.parts.rigid_object import RigidObject

CHANNELS = 28
DILATIONS = (1, 2, 4, 8)
"""Of the convolutions at a quarter of the picture's size: they see 15 cells in each direction."""

SEEN = 6
"""Numbers of what is seen: the pose, m and rad, and the logarithms of its variances."""

TYPICAL = (-12.0, -12.0, -8.0)
"""Logarithms of variances with which training starts, m² and rad²: 2.5 px and 1°."""


class PoseNetwork(nn.Module):
    """The pose of an object in a picture, and the logarithms of its variances.

    Args:
        body: The object.
    """

    grid: Tensor

    def __init__(self, body: RigidObject) -> None:
        super().__init__()
        self.body, corners = body, len(body.keypoints)
        layers: list[nn.Module] = [
            *(nn.Conv2d(3, 16, 3, stride=2, padding=1), nn.ReLU()),
            *(nn.Conv2d(16, CHANNELS, 3, stride=2, padding=1), nn.ReLU()),
        ]
        for dilation in DILATIONS:
            convolution = nn.Conv2d(CHANNELS, CHANNELS, 3, padding=dilation, dilation=dilation)
            layers += [convolution, nn.ReLU()]
        self.features = nn.Sequential(*layers)
        self.heatmaps = nn.Conv2d(CHANNELS, corners, 1)
        told = 2 * CHANNELS + 2 * corners
        self.variances = nn.Sequential(nn.Linear(told, 16), nn.ReLU(), nn.Linear(16, 3))

    def forward(self, picture: Tensor) -> tuple[Tensor, Tensor]:
        """What is seen, and the corners.

        Args:
            picture: ``(B, 3, h, w)``, 0 to 1.

        Returns:
            Pose and logarithms of variances ``(B, 6)``, corners ``(B, K, 2)``, m.
        """
        features = self.features(picture - 0.5)
        share = self.heatmaps(features).flatten(-2).softmax(-1)
        places = _places(features)
        corners = share @ places

        # How far each heatmap spreads, and how far its corner is from where the object has it.
        pose = self.body.registration(corners)
        off = norm(corners - self.body.keypoints_at(pose))
        spread = (share @ places.square() - corners.square()).sum(-1).clamp(min=1e-12).sqrt()
        pooled = (features.mean((-2, -1)), features.amax((-2, -1)))
        told = torch.cat((*pooled, 100 * off, 100 * spread), dim=-1)
        variances = self.variances(told) + told.new_tensor(TYPICAL)
        return torch.cat((pose, variances), dim=-1), corners


def seen_off(x_pose: Tensor, z_seen: Tensor) -> Tensor:
    """The residual ``(*B, 3)`` of a pose and of what is seen ``(*B, 6)``, m and rad."""
    return pose_error(x_pose, z_seen[..., :3], 1.0)


def seen_variances(z_seen: Tensor) -> Tensor:
    """The variances ``(*B, 3)`` of the pose that is seen, m² and rad²."""
    return z_seen[..., 3:].exp()


def first_sight(z_seen: Tensor) -> tuple[Tensor, Tensor]:
    """The pose at first and its covariance, as it is seen: wide where that is unsure."""
    return z_seen[..., :3], torch.diag_embed(seen_variances(z_seen))


def _places(features: Tensor) -> Tensor:
    """Where the cells of feature maps ``(B, c, h, w)`` are in the world, ``(h w, 2)``, m."""
    height, width = features.shape[-2:]
    low, high = WORKSPACE
    x = low + (high - low) * (torch.arange(width).to(features) + 0.5) / width
    y = low + (high - low) * (torch.arange(height).to(features) + 0.5) / height
    return torch.stack(torch.meshgrid(x, y, indexing="xy"), dim=-1).flatten(0, 1)


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
            network.load_state_dict(torch.load(path, map_location="cpu", weights_only=True))
        except (OSError, RuntimeError, KeyError, ValueError) as error:
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
        """The observation with ``seen`` ``(*B, 6)`` in place of ``pixels`` ``(*B, h, w, 3)``."""
        pictures = torch.as_tensor(np.asarray(observation["pixels"]))
        batch = pictures.shape[:-3]
        flat = pictures.reshape(-1, *pictures.shape[-3:]).movedim(-1, -3)
        seen, _ = self.network(flat.float() / 255)
        told = {name: value for name, value in observation.items() if name != "pixels"}
        return {**told, "seen": seen.reshape(*batch, SEEN).double().numpy()}
