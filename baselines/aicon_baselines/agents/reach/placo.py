"""Inverse kinematics by placo, which LeRobot uses: a quadratic program in each step."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any, ClassVar, NamedTuple

import numpy as np

from aicon_baselines.agents.reach.inverse_kinematics import FloatArray, InverseKinematics


class Solver(NamedTuple):
    """A program of placo, of the robot that all of them share.

    Attributes:
        solver: It.
        task: What it is to do.
    """

    solver: Any
    task: Any


@dataclass(frozen=True)
class Placo(InverseKinematics):
    """placo with its limits of joints and speeds, and its constraint against self-collision.

    It minimises the error of the pose after a step and, by little, the way of the joints, such that
    the gaps of the robot to itself stay above a margin. Balls it does not see.

    Attributes:
        damping: The weight of the way, as placo counts it.
        gap: The margin, m.
        sight: Gaps larger than this do not count, m.
    """

    damping: float = 1e-4
    gap: float = 0.01
    sight: float = 0.15

    modules: ClassVar[tuple[str, ...]] = ("placo",)
    extra: ClassVar[str] = "kinematics"

    @cached_property
    def _robot(self) -> Any:
        """The robot of placo."""
        import placo

        from aicon_baselines.agents.reach.pinocchio_files import (
            description_files,
            pairs_of_links,
            write_pairs,
        )
        from aicon_envs.reach import Robot

        with description_files(Robot(self.robot, self.tip, self.srdf)) as folder:
            found = placo.RobotWrapper(str(folder / "robot.urdf"))
            links = {
                found.model.frames[shape.parentFrame].name
                for shape in found.collision_model.geometryObjects
            }
            counts = pairs_of_links(self.kinematics)
            write_pairs(folder, [pair for pair in combinations(sorted(links), 2) if pair in counts])
            found.load_collision_pairs(str(folder / "collisions.json"))
        return found

    @cached_property
    def _solvers(self) -> tuple[Solver, Solver]:
        """What reaches, and what goes elsewhere."""
        robot, count = self._robot, self.kinematics
        for name, low, high, speed in zip(
            count.joints, count.low, count.high, count.speed, strict=True
        ):
            robot.set_joint_limits(name, low + self.stop_distance, high - self.stop_distance)
            robot.set_velocity_limit(name, speed)

        reach, elsewhere = self._solver(), self._solver()
        pose = reach.add_frame_task(self.tip, np.eye(4))
        turns = 0.0 if self.orientation == "free" else self.lever
        pose.configure("tip", "soft", 1.0, turns)
        return Solver(reach, pose), Solver(elsewhere, elsewhere.add_joints_task())

    def _solver(self) -> Any:
        """A program with the limits that both have."""
        import placo

        solver = placo.KinematicsSolver(self._robot)
        solver.mask_fbase(True)
        solver.dt = self.dt
        solver.enable_joint_limits(True)
        solver.enable_velocity_limits(True)
        solver.add_regularization_task(self.damping)
        if len(self._robot.collision_model.collisionPairs):
            itself = solver.add_avoid_self_collisions_constraint()
            itself.self_collisions_margin = self.gap
            itself.self_collisions_trigger = self.sight
            itself.configure("itself", "hard")
        return solver

    def velocity(
        self, observation: Mapping[str, FloatArray], way: FloatArray | None = None
    ) -> FloatArray:
        """Velocities of the joints ``(n,)``, rad/s or m/s, in one episode; 0 without a solution."""
        from aicon_baselines.agents.reach.kinematics import target_rotation

        robot, names = self._robot, self.kinematics.joints
        (solver, task), (elsewhere, posture) = self._solvers
        for name, angle in zip(names, observation["q"], strict=True):
            robot.set_joint(name, float(angle))
        robot.update_kinematics()

        # Where the tip should be, or the joints after a step at full speed.
        if way is None:
            now = robot.get_T_world_frame(self.tip)
            target = np.eye(4)
            target[:3, :3] = target_rotation(self.orientation, observation, now[:3, :3])
            target[:3, 3] = observation["target_position"]
            task.T_world_frame = target
        else:
            there = observation["q"] + self._step_of(way)
            posture.set_joints(dict(zip(names, there.tolist(), strict=True)))
            solver = elsewhere

        try:
            solver.solve(True)
        except RuntimeError:  # its program has no solution
            return np.zeros(len(names))
        after = np.array([robot.get_joint(name) for name in names])
        found: FloatArray = (after - observation["q"]) / self.dt
        return found
