"""What the worlds of arms have in common: the body as the policy knows it."""

import numpy as np

from aicon_baselines.palette import BODY
from aicon_baselines.view.marks import FloatArray
from aicon_baselines.view.space import MuJoCoScene
from aicon_torch.parts.self_collision import CapsuleSegments

_OPACITY = 0.15


class ArmScene(MuJoCoScene):
    """An arm whose policy has capsules around its links."""

    def draw_body(self, segments: FloatArray) -> None:
        """Draw the capsules that the policy takes for the body.

        Args:
            segments: Their segments (C, 6), m: a start and an end each.
        """
        for index, (segment, radius) in enumerate(zip(segments, self._radii(), strict=True)):
            start, end = segment[:3], segment[3:]
            self.shapes.capsule(f"body.{index}", start, end, radius, BODY, _OPACITY)

    def progress(self) -> str:
        """The distance and the angle to the target."""
        left = self.remaining()
        return f"{1e3 * left['distance']:.0f} mm and {np.degrees(left['angle']):.0f}° to the target"

    def _radii(self) -> tuple[float, ...]:
        """The radii of the capsules, m."""
        body = self.episode.policy.model.owners["x_body"]
        for module in body.modules():
            if isinstance(module, CapsuleSegments):
                return module.radii
        return ()
