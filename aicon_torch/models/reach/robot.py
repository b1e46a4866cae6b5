"""What the model knows of a robot: its joints and its shape, read from its description."""

from dataclasses import dataclass
from pathlib import Path

from aicon_torch.parts.capsules import Capsules
from aicon_torch.parts.chain import Chain


@dataclass(frozen=True)
class Robot:
    """An arm. Build one with :meth:`from_urdf`.

    Attributes:
        chain: Its joints, with their limits and speeds.
        shape: Its capsules; None for an arm that need not avoid itself.
    """

    chain: Chain
    shape: Capsules | None = None

    @classmethod
    def from_urdf(
        cls,
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
            collisions: Whether to fit capsules to the collision geometry, which takes seconds.

        Raises:
            OptionError: See :meth:`aicon_torch.parts.Chain.from_urdf`.
            ModuleNotFoundError: If an extra package is missing.
        """
        chain = Chain.from_urdf(source, tip, base)
        if not collisions:
            return cls(chain)
        return cls(chain, Capsules.from_urdf(source, srdf, tip, base))
