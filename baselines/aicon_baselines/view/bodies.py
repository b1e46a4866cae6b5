"""MuJoCo's shapes in the scene: each as a mesh that follows its place."""

from typing import Any

import mujoco
import numpy as np
import trimesh

from aicon_baselines.view.marks import FloatArray
from aicon_baselines.view.server import viser

_Shape = mujoco.mjtGeom

_INVISIBLE_GROUP = 3  # groups from here on are hidden in MuJoCo's own viewer
_PLANE = 3.0  # m; how far planes without an end are drawn


class MuJoCoBodies:
    """The shapes and visible sites of a MuJoCo scene.

    Args:
        server: The server of the page.
        model: The scene.
        data: Its state, which may change.
        shown_groups: Groups that are drawn besides those that MuJoCo's viewer shows.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        shown_groups: tuple[int, ...] = (),
    ) -> None:
        self._scene = server.scene
        self._placed: list[tuple[Any, FloatArray, FloatArray]] = []  # with place and rotation

        for geom in range(model.ngeom):
            group = int(model.geom_group[geom])
            if group < _INVISIBLE_GROUP or group in shown_groups:
                mesh = _mesh_of_geom(model, geom)
                handle = self._add(f"/geom/{geom}", mesh, model.geom_rgba[geom])
                self._placed.append((handle, data.geom_xpos[geom], data.geom_xmat[geom]))

        for site in range(model.nsite):
            if model.site_group[site] < _INVISIBLE_GROUP and model.site_rgba[site, 3] > 0.0:
                mesh = _primitive(model.site_type[site], model.site_size[site])
                handle = self._add(f"/site/{site}", mesh, model.site_rgba[site])
                self._placed.append((handle, data.site_xpos[site], data.site_xmat[site]))

    def draw(self) -> None:
        """Bring every shape to where it is now."""
        rotation = np.zeros(4)
        for handle, position, matrix in self._placed:
            mujoco.mju_mat2Quat(rotation, matrix)
            handle.position, handle.wxyz = position, rotation

    def _add(self, name: str, mesh: trimesh.Trimesh, rgba: FloatArray) -> Any:
        """Add a mesh, not yet in its place."""
        red, green, blue, alpha = rgba.tolist()
        return self._scene.add_mesh_simple(
            name,
            np.asarray(mesh.vertices, np.float32),
            np.asarray(mesh.faces, np.uint32),
            color=(round(255 * red), round(255 * green), round(255 * blue)),
            opacity=None if alpha >= 1.0 else alpha,
            flat_shading=True,
            side="double",
            cast_shadow=False,
            receive_shadow=False,
        )


def _mesh_of_geom(model: mujoco.MjModel, geom: int) -> trimesh.Trimesh:
    """A geom's shape in its own frame."""
    if model.geom_type[geom] != _Shape.mjGEOM_MESH:
        return _primitive(model.geom_type[geom], model.geom_size[geom])

    mesh = model.geom_dataid[geom]
    first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    vertices = model.mesh_vert[first : first + count]
    first, count = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
    return trimesh.Trimesh(vertices, model.mesh_face[first : first + count], process=False)


def _primitive(kind: int, size: FloatArray) -> trimesh.Trimesh:
    """A simple shape by MuJoCo's type and sizes: half lengths, the radius first."""
    radius, length = float(size[0]), 2.0 * float(size[1])
    shape: trimesh.Trimesh
    if kind == _Shape.mjGEOM_PLANE:
        extent = [side if side > 0.0 else _PLANE for side in size[:2].tolist()]
        shape = trimesh.creation.box((2.0 * extent[0], 2.0 * extent[1], 1e-4))
    elif kind == _Shape.mjGEOM_BOX:
        shape = trimesh.creation.box(2.0 * size)
    elif kind == _Shape.mjGEOM_CYLINDER:
        shape = trimesh.creation.cylinder(radius, length, sections=24)
    elif kind == _Shape.mjGEOM_CAPSULE:
        shape = trimesh.creation.capsule(length, radius, count=[16, 16])
    else:
        # Spheres have one size, ellipsoids three.
        ball = trimesh.creation.icosphere(3)
        scale = size if kind == _Shape.mjGEOM_ELLIPSOID else np.full(3, radius)
        shape = trimesh.Trimesh(ball.vertices * scale, ball.faces, process=False)
    return shape
