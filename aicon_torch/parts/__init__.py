"""What graphs are made of: in SI units, each usable alone."""

from aicon_torch.parts.approach import Approach, ToolAxis
from aicon_torch.parts.arrive import Arrive
from aicon_torch.parts.camera import (
    STEERED_COMPONENTS,
    CameraFrame,
    Intrinsics,
    Visibility,
    split_frame,
    to_world,
)
from aicon_torch.parts.capsules import Capsules
from aicon_torch.parts.chain import Chain, Joint
from aicon_torch.parts.clearance import (
    Clearance,
    ClearanceLimits,
    CollisionLikelihood,
    direction_residual,
    range_residual,
    slide,
    slide_jacobian,
    unit_gradient_jacobian,
    unit_gradient_residual,
)
from aicon_torch.parts.clock import clock
from aicon_torch.parts.commands import DisplacementCommand, ForceServo
from aicon_torch.parts.contact import (
    ContactLikelihood,
    closest_point,
    fixed_closest_point,
    inward_normal,
    is_interior,
    tangent,
)
from aicon_torch.parts.contact_dynamics import ContactDynamics
from aicon_torch.parts.contact_options import ContactOptions
from aicon_torch.parts.end_effector import EndEffector, ToolPose
from aicon_torch.parts.grasp import Carrying, Grasp, Held, approached, carried, way_from_above
from aicon_torch.parts.gripper import Gripper
from aicon_torch.parts.handle import Button, Handle
from aicon_torch.parts.hinge import SquaredHinge
from aicon_torch.parts.joint_limits import JointLimits
from aicon_torch.parts.keypoint_offset import KeypointOffset
from aicon_torch.parts.lag import Lag
from aicon_torch.parts.landmark import (
    BearingPrior,
    Landmark,
    approach,
    bearing_jacobian,
    bearing_residual,
    expected_distance,
)
from aicon_torch.parts.moving_discs import MovingDiscs
from aicon_torch.parts.moving_obstacle import MovingObstacle
from aicon_torch.parts.obstacle import Obstacle, moving_point
from aicon_torch.parts.planar import cross, norm, pose_error, quarter_turn, rotate
from aicon_torch.parts.planar_dither import PlanarDither
from aicon_torch.parts.pose import (
    FixedTarget,
    KeypointRegistration,
    PoseDistance,
    PoseMotion,
    resting_pose,
)
from aicon_torch.parts.pose_reach import PoseReach
from aicon_torch.parts.prior import ReadingPrior, first_belief
from aicon_torch.parts.recent import Recent
from aicon_torch.parts.rigid_object import RigidObject, RigidShape
from aicon_torch.parts.robot import Robot
from aicon_torch.parts.room import Room, worth_of_room
from aicon_torch.parts.round_object import RoundObject
from aicon_torch.parts.self_collision import (
    Capsule,
    CapsuleSegments,
    SelfCollision,
    segment_distance,
)
from aicon_torch.parts.servo import PositionTarget, PusherMotion, Servo
from aicon_torch.parts.solids import Solid, Solids, reading_of
from aicon_torch.parts.table import Table
from aicon_torch.parts.tip_metric import TipMetric
from aicon_torch.parts.tip_pose import TipPose
from aicon_torch.parts.touch import ContactForce, ForceThreshold, TouchedSide, TouchedTop
from aicon_torch.parts.velocity_lag import VelocityLag
from aicon_torch.parts.walls import Walls
from aicon_torch.parts.wheels import Bicycle, DifferentialDrive, Wheels
from aicon_torch.parts.workspace import Workspace
from aicon_torch.vectors import wrap_angle

__all__ = [
    "STEERED_COMPONENTS",
    "Approach",
    "Arrive",
    "BearingPrior",
    "Bicycle",
    "Button",
    "CameraFrame",
    "Capsule",
    "CapsuleSegments",
    "Capsules",
    "Carrying",
    "Chain",
    "Clearance",
    "ClearanceLimits",
    "CollisionLikelihood",
    "ContactDynamics",
    "ContactForce",
    "ContactLikelihood",
    "ContactOptions",
    "DifferentialDrive",
    "DisplacementCommand",
    "EndEffector",
    "FixedTarget",
    "ForceServo",
    "ForceThreshold",
    "Grasp",
    "Gripper",
    "Handle",
    "Held",
    "Intrinsics",
    "Joint",
    "JointLimits",
    "KeypointOffset",
    "KeypointRegistration",
    "Lag",
    "Landmark",
    "MovingDiscs",
    "MovingObstacle",
    "Obstacle",
    "PlanarDither",
    "PoseDistance",
    "PoseMotion",
    "PoseReach",
    "PositionTarget",
    "PusherMotion",
    "ReadingPrior",
    "Recent",
    "RigidObject",
    "RigidShape",
    "Robot",
    "Room",
    "RoundObject",
    "SelfCollision",
    "Servo",
    "Solid",
    "Solids",
    "SquaredHinge",
    "Table",
    "TipMetric",
    "TipPose",
    "ToolAxis",
    "ToolPose",
    "TouchedSide",
    "TouchedTop",
    "VelocityLag",
    "Visibility",
    "Walls",
    "Wheels",
    "Workspace",
    "approach",
    "approached",
    "bearing_jacobian",
    "bearing_residual",
    "carried",
    "clock",
    "closest_point",
    "cross",
    "direction_residual",
    "expected_distance",
    "first_belief",
    "fixed_closest_point",
    "inward_normal",
    "is_interior",
    "moving_point",
    "norm",
    "pose_error",
    "quarter_turn",
    "range_residual",
    "reading_of",
    "resting_pose",
    "rotate",
    "segment_distance",
    "slide",
    "slide_jacobian",
    "split_frame",
    "tangent",
    "to_world",
    "unit_gradient_jacobian",
    "unit_gradient_residual",
    "way_from_above",
    "worth_of_room",
    "wrap_angle",
]
