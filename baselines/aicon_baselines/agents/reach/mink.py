"""Inverse kinematics by mink: a quadratic program in each step."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from aicon_baselines.agents.reach.inverse_kinematics import FloatArray, InverseKinematics


@dataclass(frozen=True)
class Mink(InverseKinematics):
    """mink with its limits of joints, speeds and collisions, each as a velocity damper.

    It minimises ‖J q̇ dt − k dt h‖² + μ ‖q̇ dt‖², the error h as in damped least squares, such that
    no gap d, of the robot to itself or a ball, closes faster than (d − d_min)/T.

    Attributes:
        damping: μ of each squared rad, m².
        gap: d_min, m.
        sight: Gaps larger than this do not count, m.
        braking_time: T of gaps and stops, s.
    """

    damping: float = 1e-4
    gap: float = 0.01
    sight: float = 0.15
    braking_time: float = 0.2

    modules: ClassVar[tuple[str, ...]] = ("mink",)

    @cached_property
    def _problem(self) -> tuple[Any, Any, Any, list[Any]]:
        """Configuration, the tasks to reach and to go elsewhere, and limits."""
        import mink

        robot = self.kinematics
        configuration = mink.Configuration(robot.model)
        task = mink.FrameTask(
            "tip",
            "site",
            position_cost=1.0,
            orientation_cost=0.0 if self.orientation == "free" else self.lever,
            gain=min(1.0, self.gain * self.dt),
        )

        share = min(1.0, self.dt / self.braking_time)
        speeds = dict(zip(robot.joints, robot.speed.tolist(), strict=True))
        limits = [
            mink.ConfigurationLimit(robot.model, share, self.stop_distance),
            mink.VelocityLimit(robot.model, speeds),
            mink.CollisionAvoidanceLimit(
                robot.model,
                robot.pairs_that_can_meet(),
                gain=share * self.dt,  # mink divides it by dt, but bounds displacements
                minimum_distance_from_collisions=self.gap,
                collision_detection_distance=self.sight,
            ),
        ]
        return configuration, task, mink.PostureTask(robot.model, cost=1.0), limits

    def velocity(
        self, observation: Mapping[str, FloatArray], way: FloatArray | None = None
    ) -> FloatArray:
        """Velocities of the joints ``(n,)``, rad/s or m/s, in one episode; 0 without a solution."""
        import mink

        from aicon_baselines.agents.reach.kinematics import target_rotation

        robot, (configuration, reach, posture, limits) = self.kinematics, self._problem
        for number in range(1, self.balls + 1):
            configuration.data.mocap_pos[number] = observation[f"ball_{number}"]
        configuration.update(robot.full_positions(observation["q"]))

        # Where the tip should be, or the joints after a step at full speed.
        now = configuration.get_transform_frame_to_world("tip", "site")
        rotation = target_rotation(self.orientation, observation, now.rotation().as_matrix())
        target = mink.SE3.from_rotation_and_translation(
            mink.SO3.from_matrix(rotation), observation["target_position"]
        )
        reach.set_target(target)
        task = reach
        if way is not None:
            there = observation["q"] + self._step_of(way)
            posture.set_target(robot.full_positions(there))
            task = posture

        try:
            velocities = mink.solve_ik(
                configuration, [task], self.dt, "daqp", damping=self.damping, limits=limits
            )
        except mink.NoSolutionFound:
            return np.zeros(len(robot.joints))
        return robot.own(velocities)
