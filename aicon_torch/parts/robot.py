"""A robot: its joints and its shape, read from its description."""

import warnings
from dataclasses import dataclass
from pathlib import Path

from aicon_torch.parts.capsules import Capsules
from aicon_torch.parts.chain import Chain


@dataclass(frozen=True, eq=False)
class Robot:
    """An arm, and all that most graphs know of one. :meth:`from_urdf` reads it.

    Attributes:
        chain: Its joints, with their limits and speeds, up to its tip.
        shape: Its capsules; None for an arm that need not avoid itself.

    Example:
        >>> arm = Robot.from_urdf("ur5.urdf", tip="tool0", srdf="ur5.srdf")
        >>> end_effector = EndEffector(arm.chain, TipPose("full", lever=0.2))
        >>> goal = SelfCollision(arm.shape.capsules, SquaredHinge(0.05, 1.0), arm.shape.pairs)
    """

    chain: Chain
    shape: Capsules | None = None

    @staticmethod
    def from_urdf(
        source: str | Path,
        tip: str | None = None,
        base: str | None = None,
        srdf: str | Path | None = None,
        collisions: bool = True,
    ) -> "Robot":
        """The robot that a URDF describes.

        Args:
            source: A file, next to its meshes, or its text.
            tip: The link that reaches; may be left out if the robot does not branch and has no
                gripper.
            base: The link in whose frame everything is; the root by default.
            srdf: A file, or the text of one, that says which links need not be compared.
            collisions: Whether to fit capsules to the collision geometry, which takes seconds the
                first time. Where the URDF has none, there is a warning, and the robot has no shape.

        Raises:
            OptionError: See :meth:`aicon_torch.parts.Chain.from_urdf`.
            ModuleNotFoundError: If an extra package is missing.
        """
        chain = Chain.from_urdf(source, tip, base)
        shape = Capsules.from_urdf(source, srdf, tip, base) if collisions else None
        if shape is not None and not shape.capsules:
            warnings.warn(
                "The URDF has no collision geometry, so the robot has no shape: nothing keeps it "
                "off itself or off anything else. Expected a <collision> in its links, or "
                "collisions=False.",
                stacklevel=2,
            )
            shape = None
        return Robot(chain, shape)
