import copy
from typing import Any

import pytest
import torch
from _inputs.robots import ROBOTS, random_postures, read_chain
from torch.fx.experimental.proxy_tensor import make_fx

from aicon_torch import Actuator, Deterministic, Goal, Policy, Sensor, WorldModel
from aicon_torch.errors import OptionError
from aicon_torch.parts import chain as chain_module
from aicon_torch.parts.chain import Chain, Joint

pytest.importorskip("pytorch_kinematics")

LIFT = """
<robot name="lift">
  <link name="base"/><link name="carriage"/><link name="arm"/>
  <joint name="lift" type="prismatic">
    <parent link="base"/><child link="carriage"/>
    <axis xyz="0 1 1"/><limit lower="0" upper="1" velocity="0.5" effort="1"/>
  </joint>
  <joint name="turn" type="continuous">
    <parent link="carriage"/><child link="arm"/>
    <origin xyz="0.3 0 0" rpy="0.1 0.2 0.3"/><axis xyz="1 -2 0.5"/>
  </joint>
</robot>"""


def traced(chain: Chain) -> Any:
    """What a step computes: links, the slope of a cost of the tip, and the Jacobian."""

    def step(q: torch.Tensor) -> tuple[torch.Tensor, ...]:
        leaf = q.detach().requires_grad_()
        frames = chain.frames(leaf)
        (slope,) = torch.autograd.grad(frames[..., -1, :3, 3].square().sum(), leaf)
        return frames.detach(), slope, chain.jacobian(q)

    return step


@pytest.mark.parametrize("batch", [(), (4,)], ids=str)
def test_a_step_is_traced_into_one_graph(batch: tuple[int, ...]) -> None:
    chain = Chain.from_urdf(LIFT)
    here = torch.tensor([0.2, 0.7], dtype=torch.float64).expand(*batch, 2)
    there = torch.tensor([0.4, -2.0], dtype=torch.float64).expand(*batch, 2)

    step = traced(chain)
    graph = make_fx(step)(here)
    for found, wanted in zip(graph(there), step(there), strict=True):
        torch.testing.assert_close(found, wanted)


@pytest.mark.parametrize(
    "batch", [*(pytest.param(b, marks=pytest.mark.slow) for b in ((), (3,))), (2, 3)], ids=str
)
@pytest.mark.parametrize("name", ROBOTS)
def test_the_traced_step_of_every_robot_is_the_untraced(name: str, batch: tuple[int, ...]) -> None:
    chain = read_chain(name)
    here, there = random_postures(chain, 12).chunk(2)
    count = torch.Size(batch).numel()

    step = traced(chain)
    graph = make_fx(step)(here[:count].reshape(*batch, -1))
    q = there[:count].reshape(*batch, -1)
    for found, wanted in zip(graph(q), step(q), strict=True):
        torch.testing.assert_close(found, wanted, rtol=0, atol=1e-12)


@pytest.mark.slow
@pytest.mark.filterwarnings("error")  # a fallback would warn
def test_a_compiled_policy_does_what_the_uncompiled_does() -> None:
    chain = read_chain("ur5")

    def moved(z_q: torch.Tensor, a: torch.Tensor, dt: float) -> torch.Tensor:
        return z_q + a * dt

    def tip(x_q: torch.Tensor) -> torch.Tensor:
        return chain(x_q)[..., :3, 3]

    def distance(x_tip: torch.Tensor, z_target: torch.Tensor) -> torch.Tensor:
        return (x_tip - z_target).norm(dim=-1)

    count = len(chain.names)
    model = WorldModel(
        sensors={"z_q": Sensor(count, "rad"), "z_target": Sensor(3, "m")},
        actuators={"a": Actuator(count, "rad/s", limit=1.0)},
        estimators=[Deterministic("x_q", moved), Deterministic("x_tip", tip)],
        goals=[Goal("reach", distance)],
        dt=0.02,
    )
    policy = Policy(model)
    compiled = policy.compile()

    target = torch.tensor([0.4, 0.2, 0.5], dtype=torch.float64)
    memory = other_memory = None
    for q in random_postures(chain, 3):
        observation = {"z_q": q, "z_target": target}
        action, memory = policy.predict(observation, memory)
        other, other_memory = compiled.predict(observation, other_memory)
        torch.testing.assert_close(other, action, rtol=0, atol=1e-6)


def test_the_second_derivative_is_that_of_the_frames() -> None:
    chain = Chain.from_urdf(LIFT)
    q = torch.tensor([0.2, 0.7], dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(chain, q)
    assert torch.autograd.gradgradcheck(chain, q)


def test_a_velocity_of_the_joints_moves_the_tip_by_the_jacobian() -> None:
    chain = Chain.from_urdf(LIFT)
    q = torch.tensor([[0.2, 0.7], [0.4, -2.0]], dtype=torch.float64)
    speed, dt = torch.tensor([0.3, -0.8], dtype=torch.float64), 1e-6

    before, after = chain(q - 0.5 * dt * speed), chain(q + 0.5 * dt * speed)
    turning = (after - before)[..., :3, :3] @ chain(q)[..., :3, :3].mT / dt  # [ω]×
    angular = torch.stack((turning[:, 2, 1], turning[:, 0, 2], turning[:, 1, 0]), dim=-1)
    expected = torch.cat(((after - before)[..., :3, 3] / dt, angular), dim=-1)

    found = (chain.jacobian(q) @ speed.unsqueeze(-1)).squeeze(-1)
    torch.testing.assert_close(found, expected, rtol=0, atol=1e-8)


def test_a_chain_knows_its_joints() -> None:
    chain = Chain.from_urdf(LIFT)
    assert chain.names == ("lift", "turn")
    assert chain.low.tolist() == [0.0, -torch.inf]
    assert chain.high.tolist() == [1.0, torch.inf]
    assert chain.speed.tolist() == [0.5, torch.inf]


def test_a_chain_can_be_copied_and_moved() -> None:
    chain = Chain.from_urdf(LIFT)
    q = torch.tensor([0.2, 0.7], dtype=torch.float64)
    torch.testing.assert_close(copy.deepcopy(chain).to("cpu")(q), chain(q))
    assert chain.to("meta")(q.to("meta")).device.type == "meta"


def test_a_base_is_the_frame_of_everything() -> None:
    q = torch.tensor([0.2, 0.7], dtype=torch.float64)
    whole, upper = Chain.from_urdf(LIFT), Chain.from_urdf(LIFT, base="carriage")
    expected = torch.linalg.inv(whole.frames(q)[0]) @ whole(q)
    torch.testing.assert_close(upper(q[1:]), expected)


def test_a_robot_can_be_given_by_its_numbers() -> None:
    described = Chain.from_urdf(LIFT)
    product = described.product
    fixed = (product.constant + product.by_cos).tolist()  # at q = 0
    joints = [Joint("lift", (0.0, 0.5**0.5, 0.5**0.5), slides=True), Joint("turn")]
    joints[1] = joints[1]._replace(axis=tuple(described.axes[1].tolist()))

    q = torch.tensor([0.2, 0.7], dtype=torch.float64)
    torch.testing.assert_close(Chain(fixed, torch.eye(4).tolist(), joints)(q), described(q))


def test_joints_must_be_as_many_as_the_transforms() -> None:
    identity = torch.eye(4).tolist()
    with pytest.raises(OptionError, match="joints has 1 of them: expected 2, as fixed"):
        Chain([identity, identity], identity, [Joint("only")])


def test_a_product_that_differs_from_the_library_is_an_error(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(chain_module, "LARGEST_DIFFERENCE", 0.0)
    with pytest.raises(ArithmeticError, match="differ by .* for the joints 'lift', 'turn'"):
        Chain.from_urdf(LIFT)


def test_without_the_library_an_error_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def missing(name: str) -> None:
        raise ModuleNotFoundError(f"No module named {name!r}", name=name)

    monkeypatch.setattr("aicon_torch.extras.import_module", missing)
    command = r"pytorch_kinematics is missing; .* pip install 'aicon-torch\[robots\]'"
    with pytest.raises(ModuleNotFoundError, match=command):
        Chain.from_urdf(LIFT)
