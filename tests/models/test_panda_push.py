import math

import numpy as np
import pytest
import torch

from aicon_torch import make_policy, presets
from aicon_torch.models.panda_push import Options, world_model
from aicon_torch.parts.joint_limits import BodyFrames, SelfCollision, Workspace, segment_distance
from aicon_torch.parts.camera import Visibility
from aicon_torch.parts.chain import EndEffector, Kinematics, tool_frame
from aicon_torch.parts.image_registration import Registration, View
from aicon_torch.models.panda_push.robot import PANDA, Robot
from aicon_torch.parts.contact import ContactLikelihood, closest_point
from aicon_torch.parts.contact_dynamics import ContactDynamics
from panda_merging import rises

HOME = torch.tensor([0.1, 0.3, -0.2, -2.2, 0.1, 2.5, 0.6], dtype=torch.float64)


def joints(count):
    generator = torch.Generator().manual_seed(0)
    return HOME + 0.2 * torch.randn(count, 7, generator=generator, dtype=torch.float64)


@pytest.fixture(scope="module")
def kinematics():
    return Kinematics(PANDA)


def observation(batch=(), **changes):
    readings = {
        "q": HOME.expand(*batch, 7),
        "target": torch.tensor([0.54, 0.05, 0.4], dtype=torch.float64).expand(*batch, 3),
        "object_pose": torch.tensor([0.5, -0.05, -0.8], dtype=torch.float64).expand(*batch, 3),
    }
    return readings | changes


def test_the_jacobian_is_the_derivative_of_the_end_effector(kinematics):
    q = joints(5)
    given = kinematics.jacobian(kinematics.frames(q))
    plain = EndEffector(kinematics, "transpose")
    expected = torch.autograd.functional.jacobian(lambda x: plain(x).sum(0), q).permute(1, 0, 2)
    torch.testing.assert_close(given, expected)


def test_the_natural_pullback_moves_the_end_effector_along_the_gradient_and_is_as_long_as_its_cost_falls():
    kinematics = Kinematics(PANDA, damping=1e-6)
    q = joints(4).requires_grad_()
    wish = torch.randn(4, 6, generator=torch.Generator().manual_seed(1), dtype=torch.float64)
    (step,) = torch.autograd.grad(EndEffector(kinematics)(q), q, wish)
    moved = (kinematics.jacobian(kinematics.frames(q.detach())) @ step.unsqueeze(-1)).squeeze(-1)
    along = torch.nn.functional.normalize(moved, dim=-1)
    torch.testing.assert_close(along, torch.nn.functional.normalize(wish, dim=-1), rtol=1e-4, atol=1e-6)
    length = step.norm(dim=-1)
    torch.testing.assert_close((wish * moved).sum(-1) / length, length)  # h·J u for the unit u of the step


def test_near_a_singularity_the_end_effector_does_not_outgrow_what_it_meets(kinematics):
    q = HOME.clone()
    q[[0, 2, 4]], q[3], q[5] = 0.0, -0.467, 1.66
    jacobian = kinematics.jacobian(kinematics.frames(q))
    assert torch.linalg.svdvals(jacobian)[-1] < 0.01
    outward = torch.tensor([1.0, 0.0, 0.0, 0.0, 0.0, 0.0], dtype=torch.float64)
    assert kinematics.solve(jacobian, outward).norm() > 1 > kinematics.natural(jacobian, outward).norm()


def test_the_end_effector_tells_where_the_tool_is(kinematics):
    frames = kinematics.frames(joints(6))
    rotation, origin = tool_frame(kinematics.end_effector(frames), PANDA.stick_length)
    torch.testing.assert_close(rotation, frames[:, 7, :3, :3])
    torch.testing.assert_close(origin, frames[:, 7, :3, 3])


def test_the_pushing_model_is_that_of_pusht_itself():
    model = world_model(Options())
    functions = {name: node.relation.function for name, node in model.owners.items() if hasattr(node, "relation")}
    assert type(functions["x_obj"]) is ContactDynamics
    assert type(functions["p_contact"]) is ContactLikelihood
    assert functions["x_contact"] is closest_point


@pytest.mark.parametrize("sensing", ["pose", "camera"])
def test_the_graph_of_pusht_is_part_of_the_arms(sensing):
    small = {(p.goal, p.quantities) for p in make_policy("pusht").model.paths()}
    large = {(p.goal, p.quantities[: len(q)]) for p in world_model(Options(sensing=sensing)).paths() for _, q in small}
    assert small <= large


def test_the_uncertainty_reaches_the_joints_through_the_camera():
    paths = [str(path) for path in world_model(Options()).paths()]
    assert "push → P_pose → x_cam → x_ee → x_joints → a" in paths
    assert "heights → x_heights → x_ee → x_joints → a" in paths
    assert "limits → x_joints → a" in paths
    assert "collisions → x_body → x_joints → a" in paths


@pytest.mark.parametrize("preset", presets("panda_push"))
def test_every_preset_acts_within_the_limits(preset):
    policy = make_policy("panda_push", preset=preset, sensing="pose")
    memory = None
    for _ in range(3):
        action, memory = policy.predict(observation(), memory)
    assert action.isfinite().all() and (action.abs() <= torch.tensor(PANDA.speed)).all()


def test_a_batch_is_its_rows():
    policy = make_policy("panda_push", sensing="pose")
    rows, single = observation((3,)), []
    rows["q"] = joints(3)
    together, _ = policy.predict(rows)
    for row in range(3):
        action, _ = policy.predict({key: value[row] for key, value in rows.items()})
        single.append(action)
    torch.testing.assert_close(together, torch.stack(single), rtol=1e-6, atol=1e-9)


def test_height_is_a_goal_of_its_own():
    policy = make_policy("panda_push", sensing="pose")
    kinematics = Kinematics(PANDA)
    q, memory = HOME.clone(), None
    with torch.no_grad():
        before = kinematics.end_effector(kinematics.frames(q))[2]
        for _ in range(100):
            action, memory = policy.predict(observation(q=q), memory)
            q = q + 0.01 * action
        after = kinematics.end_effector(kinematics.frames(q))[2]
    assert abs(after - 0.02) < abs(before - 0.02)


def test_near_a_limit_the_joint_turns_back():
    policy = make_policy("panda_push", sensing="pose")
    q = HOME.clone()
    q[6] = PANDA.high[6] - 0.02
    memory = None
    for _ in range(100):
        action, memory = policy.predict(observation(q=q), memory)
        q = q + 0.01 * action
        assert q[6] < PANDA.high[6]
    assert q[6] < PANDA.high[6] - 0.04


def test_the_workspace_ends_where_the_arm_is_straight(kinematics):
    straight = -math.atan(0.0825 / 0.316) - math.atan(0.0825 / 0.384)
    q = torch.tensor([0.0, 1.2, 0.0, straight, 0.0, 1.7, 0.0], dtype=torch.float64)
    goal = torch.tensor([0.02, 0.0], dtype=torch.float64)  # height of the tip, and no tilt
    for _ in range(20):
        frames = kinematics.frames(q)
        here = kinematics.end_effector(frames)[2:4]
        jacobian = kinematics.jacobian(frames)[2:4][:, [1, 5]]
        q[[1, 5]] += torch.linalg.solve(jacobian, goal - here)
    x_ee = kinematics.end_effector(kinematics.frames(q))
    torch.testing.assert_close(x_ee[2:4], goal)
    assert x_ee[:2].norm() == pytest.approx(PANDA.reach, abs=1e-3)
    assert torch.linalg.svdvals(kinematics.jacobian(kinematics.frames(q)))[-1] < 1e-3
    cost = Workspace(PANDA, 0.02, 15.0)
    assert cost(x_ee) > 14 and cost(0.97 * x_ee) == 0


@pytest.mark.parametrize(("preset", "crosses"), [("aicon", False), ("no_workspace", True)])
def test_the_elbow_does_not_bend_the_other_way_where_the_object_is_out_of_reach(preset, crosses, kinematics):
    policy = make_policy("panda_push", preset=preset, sensing="pose")
    far = {"object_pose": torch.tensor([0.76, 0.05, 1.0]), "target": torch.tensor([0.5, 0.05, 1.0])}
    q, memory, elbow = HOME.clone(), None, []
    for _ in range(400):
        action, memory = policy.predict(observation(q=q, **far), memory)
        q = q + 0.01 * action
        elbow.append(float(q[3]))
    assert (max(elbow) > -0.467) == crosses


def test_what_was_settled_at_the_end_effector_stays_so_with_the_natural_pullback():
    draw = torch.Generator().manual_seed
    merged, _, inherited = rises(4, "natural", 500, draw(0))
    assert merged == 0 and inherited > 0
    merged, _, inherited = rises(4, "transpose", 500, draw(0))
    assert merged > 0 and inherited == 0


def test_segments_are_as_far_apart_as_their_nearest_points():
    first, second = torch.randn(2, 50, 6, generator=torch.Generator().manual_seed(2), dtype=torch.float64)
    share = torch.linspace(0, 1, 201, dtype=torch.float64)
    points = [s[:, None, :3] + share[:, None] * (s[:, None, 3:] - s[:, None, :3]) for s in (first, second)]
    expected = torch.cdist(*points).amin((-1, -2))
    torch.testing.assert_close(segment_distance(first, second), expected, rtol=0, atol=2e-2)
    assert (segment_distance(first, second) <= expected + 1e-9).all()


def test_what_is_near_the_border_is_seen_less_well(kinematics):
    model = world_model(Options())
    camera = model.owners["x_cam"].relation.function
    x_ee = kinematics.end_effector(kinematics.frames(HOME))
    visibility = Visibility(PANDA, 600.0, (1.0, 1.0, 1.0), 100.0, 0.04)
    x_cam = camera(x_ee)
    ahead = x_cam[9:11] * 600.0  # below the camera
    noise = [visibility(torch.cat((ahead + shift, torch.zeros(1))), x_cam)[0] for shift in (0.0, 60.0, 150.0, 400.0)]
    assert noise == sorted(noise) and noise[-1] > 100 * noise[0]


def test_unseen_the_object_becomes_uncertain_and_the_policy_goes_on():
    policy = make_policy("panda_push")
    image = {
        "rgb": np.full((120, 160, 3), 200, np.uint8),
        "depth": np.full((120, 160), 0.3, np.float32),
        "image_age": np.zeros(1),
        "q": HOME.numpy(),
        "dq": np.zeros(7),
        "ft": np.array([0.0, 0.0, -2.4525, 0.0, 0.0, 0.0]),
        "target": np.array([0.54, 0.0, 0.0]),
    }
    _, memory = policy.predict(image)
    first = memory["P_pose"].diagonal().sum()
    for _ in range(5):
        action, memory = policy.predict(image, memory)
    assert np.isfinite(action).all() and memory["P_pose"].diagonal().sum() > first


def test_the_robot_is_that_of_the_physics(kinematics):
    pytest.importorskip("aicon_envs.panda_push")
    import mujoco

    from aicon_envs.panda_push import PandaPushEnv

    env = PandaPushEnv(obs_type="pose")
    robot = Robot.of(env.description())
    for name in ("frames", "tool", "camera", "intrinsics", "low", "high", "speed"):
        np.testing.assert_allclose(getattr(robot, name), getattr(PANDA, name), atol=1e-6)
    assert robot.tool_mass == PANDA.tool_mass and len(robot.capsules) == len(PANDA.capsules)
    model = env._simulation.model
    data = mujoco.MjData(model)
    for q in joints(5):
        data.qpos[:7] = q.numpy()
        mujoco.mj_kinematics(model, data)
        tip = kinematics.end_effector(kinematics.frames(q))[:3]
        np.testing.assert_allclose(tip, data.site("tip").xpos, atol=1e-9)
        env._simulation.data.qpos[:7] = q.numpy()
        mujoco.mj_kinematics(model, env._simulation.data)
        gap = SelfCollision(robot, 0.05, 1.0).distances(BodyFrames(kinematics, robot)(q)).min()
        np.testing.assert_allclose(gap, env._simulation.self_distance, atol=1e-8)


def test_a_rendered_object_is_found_within_2_mm(kinematics):
    pytest.importorskip("aicon_envs.panda_push")
    from aicon_envs.panda_push import PandaPushEnv

    env = PandaPushEnv()
    find = Registration(env.object.corners, PANDA.intrinsics)
    mount = np.vstack((np.array(PANDA.camera), [0.0, 0.0, 0.0, 1.0]))
    for seed in range(3):
        try:
            reading, info = env.reset(seed=seed)
        except RuntimeError:
            pytest.skip("no OpenGL without a display")
        camera = kinematics.frames(torch.tensor(reading["q"]))[7].numpy() @ mount
        view = View(reading["rgb"], reading["depth"], camera[:3, :3], camera[:3, 3])
        sight = find(view, info["object_pose"] + [0.005, -0.005, 0.05])
        assert np.linalg.norm(sight.pose[:2] - info["object_pose"][:2]) < 0.002
        assert abs(sight.pose[2] - info["object_pose"][2]) < 0.02 and sight.top == pytest.approx(0.04, abs=2e-3)
    env.close()


def test_wrong_options_are_named():
    with pytest.raises(ValueError, match="sensing='touch'"):
        make_policy("panda_push", sensing="touch")
    with pytest.raises(ValueError, match="goals="):
        make_policy("panda_push", goals=("speed",))
