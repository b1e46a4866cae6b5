"""Inverse kinematics by pink: a quadratic program in each step, about Pinocchio."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from aicon_baselines.agents.reach.inverse_kinematics import FloatArray, InverseKinematics


@dataclass(frozen=True)
class Pink(InverseKinematics):
    """pink with its limits of joints and speeds, and its barrier against self-collision.

    It minimises ‖J q̇ dt − k dt h‖² + μ ‖q̇ dt‖², the error h as in damped least squares, such that
    no gap d of the robot to itself closes faster than (d − d_min)/T. Balls it does not see.

    Attributes:
        damping: μ of each squared rad, m².
        gap: d_min, m.
        braking_time: T of gaps and stops, s.
    """

    damping: float = 1e-4
    gap: float = 0.01
    braking_time: float = 0.2

    modules: ClassVar[tuple[str, ...]] = ("pink", "daqp")
    extra: ClassVar[str] = "kinematics"

    @cached_property
    def _model(self) -> tuple[Any, Any]:
        """The robot of Pinocchio, and its shapes with the pairs of them that can meet."""
        import pinocchio

        from aicon_baselines.agents.reach.pinocchio_files import description_files, pairs_of_links
        from aicon_envs.reach import Robot

        with description_files(Robot(self.robot, self.tip, self.srdf)) as folder:
            file, collision = str(folder / "robot.urdf"), pinocchio.GeometryType.COLLISION
            model = pinocchio.buildModelFromUrdf(file)
            shapes = pinocchio.buildGeomFromUrdf(model, file, collision, package_dirs=[str(folder)])

        # Convex hulls, as in MuJoCo: the barrier needs distances that have a gradient.
        for shape in shapes.geometryObjects:
            if hasattr(shape.geometry, "buildConvexHull"):
                shape.geometry.buildConvexHull(True, "Qt")
                shape.geometry = shape.geometry.convex

        counts = pairs_of_links(self.kinematics)
        links = [model.frames[shape.parentFrame].name for shape in shapes.geometryObjects]
        for first in range(len(links)):
            for second in range(first):
                if (links[first], links[second]) in counts:
                    shapes.addCollisionPair(pinocchio.CollisionPair(second, first))

        return model, shapes

    @cached_property
    def _problem(self) -> tuple[list[int], Any, Any, list[Any], list[Any]]:
        """The places of the joints, the tasks to reach and to go elsewhere, limits and barriers."""
        import pink
        from pink.barriers import SelfCollisionBarrier
        from pink.limits import ConfigurationLimit, VelocityLimit

        model, shapes = self._model
        own = [model.joints[model.getJointId(name)].idx_v for name in self.kinematics.joints]
        within = model.copy()
        within.lowerPositionLimit[own] = self.kinematics.low + self.stop_distance
        within.upperPositionLimit[own] = self.kinematics.high - self.stop_distance
        within.velocityLimit[own] = self.kinematics.speed

        reach = pink.FrameTask(
            self.tip,
            position_cost=1.0,
            orientation_cost=0.0 if self.orientation == "free" else self.lever,
            gain=min(1.0, self.gain * self.dt),
        )
        limits = [
            ConfigurationLimit(within, min(1.0, self.dt / self.braking_time)),
            VelocityLimit(within),
        ]
        barriers = []
        if len(shapes.collisionPairs):
            barriers = [
                SelfCollisionBarrier(
                    len(shapes.collisionPairs),
                    gain=1.0 / self.braking_time,
                    safe_displacement_gain=0.0,
                    d_min=self.gap,
                )
            ]
        return own, reach, pink.PostureTask(cost=1.0), limits, barriers

    def velocity(
        self, observation: Mapping[str, FloatArray], way: FloatArray | None = None
    ) -> FloatArray:
        """Velocities of the joints ``(n,)``, rad/s or m/s, in one episode; 0 without a solution."""
        import pink
        import pinocchio

        from aicon_baselines.agents.reach.kinematics import target_rotation

        own, reach, posture, limits, barriers = self._problem
        model, shapes = self._model
        configuration = pink.Configuration(
            model,
            model.createData(),
            self._full_positions(observation["q"]),
            collision_model=shapes,
            collision_data=shapes.createData(),
        )

        # Where the tip should be, or the joints after a step at full speed.
        now = configuration.get_transform_frame_to_world(self.tip).rotation
        rotation = target_rotation(self.orientation, observation, now)
        reach.set_target(pinocchio.SE3(rotation, observation["target_position"]))
        task = reach
        if way is not None:
            posture.set_target(self._full_positions(observation["q"] + self._step_of(way)))
            task = posture

        try:
            velocities = pink.solve_ik(
                configuration,
                [task],
                self.dt,
                "daqp",
                damping=self.damping,
                limits=limits,
                barriers=barriers,
                safety_break=False,
            )
        except pink.exceptions.NoSolutionFound:
            return np.zeros(len(own))
        found: FloatArray = velocities[own]
        return found

    def _full_positions(self, joints: FloatArray) -> FloatArray:
        """Pinocchio's `q` at values of the joints, ``(n,)``."""
        import pinocchio

        model, _ = self._model
        turned = np.zeros(model.nv)
        turned[self._problem[0]] = joints
        found: FloatArray = pinocchio.integrate(model, pinocchio.neutral(model), turned)
        return found
