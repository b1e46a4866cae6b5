import pickle
from dataclasses import replace

import pytest
import torch
from _inputs.arm import pose_observation

from aicon_torch import OptionError, make_policy
from aicon_torch.models.arm_push import PANDA, CameraOptions, Options, world_model
from aicon_torch.models.pusht import PIXEL
from aicon_torch.parts.contact import ContactLikelihood, closest_point
from aicon_torch.parts.contact_dynamics import ContactDynamics

CAMERA = CameraOptions()


def relation_of(model, name):
    return model.owners[name].relation.function


def paths_of(model):
    return {str(path) for path in model.paths()}


def test_the_pushing_model_is_that_of_pusht_itself():
    model = world_model(Options())
    assert type(relation_of(model, "x_obj")) is ContactDynamics
    assert type(relation_of(model, "p_contact")) is ContactLikelihood
    assert relation_of(model, "x_contact") is closest_point


def test_its_contacts_are_those_of_pusht_but_for_the_size_of_the_object():
    ours = relation_of(world_model(Options()), "p_contact")
    theirs = relation_of(make_policy("pusht").model, "p_contact")
    ratio = 0.2 / (120 * PIXEL)
    for name in ("reach", "reaction", "aim"):
        assert getattr(ours, name) == pytest.approx(ratio * getattr(theirs, name))
    assert ours.radius == PANDA.stick_radius


@pytest.mark.parametrize("sensing", ["pose", "camera"])
def test_the_graph_of_pusht_is_part_of_the_arms(sensing):
    arm = world_model(Options(sensing=sensing))
    for path in make_policy("pusht").model.paths():
        begins = len(path.quantities)
        same = [p for p in arm.paths() if p.quantities[:begins] == path.quantities]
        assert any(p.goal == path.goal for p in same)


def test_the_uncertainty_reaches_the_joints_through_the_camera():
    paths = paths_of(world_model(Options()))
    assert "push → P_pose → x_cam → x_ee → x_joints → a" in paths
    assert "height → x_heights → x_ee → x_joints → a" in paths
    assert "joint_limits → x_joints → a" in paths
    assert "self_collision → x_body → x_joints → a" in paths


@pytest.mark.parametrize(
    "options", [Options(sensing="pose", delay=3), Options(camera=CameraOptions(delay=3))]
)
def test_where_readings_are_late_the_joints_follow_with_a_lag(options):
    late, prompt = world_model(options), world_model(replace(options, delay=0, camera=CAMERA))
    assert "joint_limits → x_joints → v_joints → a" in paths_of(late)
    assert "x_pose_lag" in late.quantities and "z_joints_recent" not in prompt.quantities
    assert "joint_limits → x_joints → a" in paths_of(prompt)
    assert "v_joints" not in prompt.quantities and "x_pose_lag" not in prompt.quantities


def test_an_object_whose_pose_is_observed_needs_no_camera():
    model = world_model(Options(sensing="pose"))
    assert "x_cam" not in model.owners and "z_ft" not in model.sensors
    assert not any("P_pose" in path for path in paths_of(model))


def test_readings_that_are_off_by_what_is_told_are_put_right():
    off, told = (0.005, -0.003, 0.01), pose_observation()
    _, plain = make_policy("arm_push", sensing="pose").predict(told)
    moved = {**told, "object_pose": told["object_pose"] + torch.tensor(off, dtype=torch.float64)}
    _, righted = make_policy("arm_push", sensing="pose", pose_offset=off).predict(moved)
    torch.testing.assert_close(righted["x_pose"], plain["x_pose"])
    with pytest.raises(OptionError, match="pose_offset=.*expected 3 finite numbers"):
        make_policy("arm_push", sensing="pose", pose_offset=0.005)


def test_a_goal_that_is_left_out_leaves_the_others_as_they_are():
    whole = make_policy("arm_push").model
    options = {"upright_tolerance": None, "workspace": None}
    options |= {"joint_limits": None, "self_collision": None}
    bare = make_policy("arm_push", **options).model
    left_out = {"upright", "workspace", "joint_limits", "self_collision"}
    assert set(whole.goals) - set(bare.goals) == left_out
    kept = {path for path in paths_of(whole) if path.split(" → ")[0] not in left_out}
    assert paths_of(bare) == kept


@pytest.mark.parametrize("sensing", ["pose", "camera"])
def test_the_graph_is_kept_in_a_pickle(sensing):
    model = world_model(Options(sensing=sensing))
    kept = pickle.loads(pickle.dumps(model))
    assert [str(path) for path in kept.paths()] == [str(path) for path in model.paths()]
