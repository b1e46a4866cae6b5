import pytest
import torch
from _inputs import normal
from torch import Tensor

from aicon_torch import Actuator, Affine, Deterministic, Goal, Sensor, WorldModel
from aicon_torch.errors import OptionError
from aicon_torch.parts.hinge import SquaredHinge
from aicon_torch.parts.obstacle import Obstacle, moving_point
from aicon_torch.parts.self_collision import Capsule

CAPSULES = (
    Capsule(0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.1), 0.05),
    Capsule(1, (0.0, 0.0, 0.0), (0.0, 0.0, 0.3), 0.04),
)


def test_capsules_of_the_base_are_left_out_and_radii_count() -> None:
    obstacle = Obstacle(0.1, CAPSULES, SquaredHinge(0.05, 1.0))
    segments = torch.tensor([[0.0, 0, 0, 0, 0, 0.1], [0.5, 0, 0, 0.5, 0, 1.0]])
    state = torch.tensor([0.0, 0.0, 0.5, 9.0, 9.0, 9.0])
    found = obstacle.gaps(segments, state)
    torch.testing.assert_close(found, torch.tensor([0.5 - 0.1 - 0.04 - 0.05]))
    assert obstacle(segments, state) == 0


def test_a_ball_of_no_size_is_refused() -> None:
    with pytest.raises(OptionError, match="radius=-1.0: expected a positive number"):
        Obstacle(-1.0, CAPSULES, SquaredHinge(0.05, 1.0))
    flat = [Capsule(1, (0.0, 0.0, 0.0), (0.0, 0.0, 0.3), 0.0)]
    with pytest.raises(OptionError, match="a radius above 0 m"):
        Obstacle(0.1, flat, SquaredHinge(0.05, 1.0))


def test_a_robot_that_cannot_give_way_is_refused() -> None:
    for capsules in ((), CAPSULES[:1]):
        with pytest.raises(OptionError, match="capsules: "):
            Obstacle(0.1, capsules, SquaredHinge(0.05, 1.0))


def test_the_motion_of_a_point_is_estimated() -> None:
    dt, velocity = 0.02, torch.tensor([0.2, -0.1, 0.0])

    def distance(x: Tensor, x_ball: Tensor) -> Tensor:
        return (x - x_ball[..., :3]).norm(dim=-1)

    model = WorldModel(
        sensors={"z_ball": Sensor(3, "m")},
        actuators={"a": Actuator(3, "m/s")},
        estimators=[Deterministic("x", Affine(a=dt)), moving_point("x_ball", "z_ball", dt)],
        goals=[Goal("follow", distance)],
        dt=dt,
    )

    values = model.initial({"z_ball": torch.zeros(3)}, ())
    assert (values["x_ball"] == 0).all()
    for step in range(1, 60):
        values = model.update(values | {"z_ball": step * dt * velocity})
    torch.testing.assert_close(values["x_ball"][3:], velocity, rtol=0, atol=5e-3)


@pytest.mark.parametrize("size", [2, 3])
def test_a_point_moves_for_as_long_as_the_clock_tells(size: int) -> None:
    motion = moving_point("x_ball", "z_ball", 0.02, size=size).double()
    state, times = normal(2, 2 * size), torch.tensor([[0.02], [0.1]], dtype=torch.float64)
    known = {"x_ball": state, "dt": times}
    moved, jacobian = motion.predict.linearize(known, "x_ball", 2 * size)
    torch.testing.assert_close(moved[:, :size], state[:, :size] + times * state[:, size:])
    torch.testing.assert_close((jacobian @ state.unsqueeze(-1)).squeeze(-1), moved)
