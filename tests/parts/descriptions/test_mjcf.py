from pathlib import Path

import pytest
import torch
from _inputs.robots import Physics

from aicon_torch.errors import OptionError
from aicon_torch.parts.chain import Chain

pytest.importorskip("pytorch_kinematics")
mujoco = pytest.importorskip("mujoco")

ARM = """
<mujoco>
  <worldbody>
    <body name="cart" pos="0.1 0.2 0.3" euler="10 20 30">
      <joint name="x" type="slide" axis="1 1 0" range="-1 1" limited="true" ref="0.2"/>
      <joint name="turn" axis="0 0 1" pos="0.2 0 0.1"/>
      <geom size="0.1"/>
      <body name="arm" pos="1 0 0" quat="1 0.1 0.2 0.3">
        <joint name="elbow" axis="0 1 0.5" pos="0 0.3 0" ref="30" range="-90 45"/>
        <geom size="0.1"/>
        <body name="hand" pos="0 0 0.5" euler="0 90 0">
          <geom size="0.1"/>
          <site name="tip" pos="0 0 0.1" euler="0 0 45"/>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>"""


def test_links_are_where_the_physics_has_them() -> None:
    chain = Chain.from_mjcf(ARM, tip="hand")
    physics = Physics(mujoco.MjModel.from_xml_string(ARM), chain.names)
    assert chain.names == ("x", "turn", "elbow")

    for q in torch.tensor([[0.2, 0.0, 0.5236], [0.7, -1.3, 0.4]], dtype=torch.float64):
        physics.move(q)
        torch.testing.assert_close(chain(q), physics.frame("hand"), rtol=0, atol=1e-12)
        wanted = physics.jacobian("hand")
        torch.testing.assert_close(chain.jacobian(q), wanted, rtol=0, atol=1e-12)


def test_a_site_can_be_the_tip(tmp_path: Path) -> None:
    file = tmp_path / "arm.xml"
    file.write_text(ARM)
    chain = Chain.from_mjcf(file, tip="tip")

    q = torch.tensor([0.3, 0.4, -0.5], dtype=torch.float64)
    physics = Physics(mujoco.MjModel.from_xml_string(ARM), chain.names)
    physics.move(q)
    position = torch.tensor(physics.data.site("tip").xpos)
    torch.testing.assert_close(chain(q)[:3, 3], position, rtol=0, atol=1e-12)


def test_limits_are_in_rad_and_m_and_speeds_unknown() -> None:
    chain = Chain.from_mjcf(ARM, tip="hand")
    assert chain.low.tolist() == pytest.approx([-1.0, -torch.inf, -torch.pi / 2])
    assert chain.high.tolist() == pytest.approx([1.0, torch.inf, torch.pi / 4])
    assert chain.speed.isinf().all()


def test_a_base_can_be_any_body_above_the_tip() -> None:
    chain = Chain.from_mjcf(ARM, tip="hand", base="cart")
    assert chain.names == ("elbow",)


def test_a_joint_that_follows_another_is_an_error() -> None:
    coupled = ARM.replace(
        "</mujoco>", '<equality><joint joint1="elbow" joint2="turn"/></equality></mujoco>'
    )
    with pytest.raises(OptionError, match="Joint 'elbow' mimics 'turn'"):
        Chain.from_mjcf(coupled, tip="hand")


def test_a_free_body_is_an_error() -> None:
    free = (
        '<mujoco><worldbody><body name="b"><freejoint/><geom size="1"/></body></worldbody></mujoco>'
    )
    with pytest.raises(OptionError, match="'joint 0' is floating"):
        Chain.from_mjcf(free, tip="b")


def test_a_missing_file_is_an_error() -> None:
    with pytest.raises(FileNotFoundError, match="no_such.xml is no file"):
        Chain.from_mjcf("no_such.xml", tip="hand")
