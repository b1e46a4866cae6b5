"""One mesh on viser's scene, drawn alike in the plane and in space."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from aicon_baselines.view.server import viser
from aicon_baselines.view.style import Color


def add_mesh(
    scene: viser.SceneApi,
    name: str,
    vertices: NDArray[np.float64],
    faces: NDArray[np.int_],
    color: Color,
    opacity: float | None = None,
) -> Any:
    """Add points (N, 3) and triangles (F, 3), seen from both sides and without a shadow.

    Returns:
        Viser's handle.
    """
    return scene.add_mesh_simple(
        f"/{name}",
        vertices.astype(np.float32),
        faces.astype(np.uint32),
        color=color,
        opacity=opacity,
        side="double",
        cast_shadow=False,
        receive_shadow=False,
    )
