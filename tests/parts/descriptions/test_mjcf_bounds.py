"""Models of MuJoCo's that are broken, or made to fill the memory."""

from pathlib import Path
from typing import Any

import pytest

from aicon_torch.errors import OptionError
from aicon_torch.parts.descriptions import compilation, read_mjcf

mujoco = pytest.importorskip("mujoco")

ARM = """
<mujoco>
  <worldbody>
    <body name="arm" pos="0 0 1">
      <joint name="elbow" axis="0 1 0" range="-90 45" ref="10"/>
      <geom size="0.1"/>
      <site name="tip" pos="0 0 0.1"/>
    </body>
  </worldbody>
</mujoco>"""


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # MuJoCo logs where it is called


@pytest.mark.parametrize(
    ("number", "other", "message"),
    [
        ('range="-90 45"', 'range="nan 45"', "Joint 'elbow': <joint range='nan 45'>: expected low"),
        ('range="-90 45"', 'range="45 -90"', "Joint 'elbow': <joint range='45 -90'>: expected low"),
        ('range="-90 45"', 'range="7 7"', "Joint 'elbow': <joint range='7 7'>: expected lower"),
        ('axis="0 1 0"', 'axis="nan 1 0"', "Joint 'elbow': nan 1 0: expected numbers within"),
        ('ref="10"', 'ref="nan"', "Joint 'elbow': nan: expected numbers within"),
        ('pos="0 0 1"', 'pos="0 1e300 1"', "Body 'arm': 0 1e+300 1: expected numbers within"),
        ('pos="0 0 0.1"', 'pos="nan 0 0"', "Site 'tip': nan 0 0: expected numbers within"),
        ('size="0.1"', 'size="-1"', "MuJoCo does not accept The text: .*must be positive in geom"),
        ('size="0.1"', 'size="nan"', "MuJoCo does not accept The text: .*nan size in geom"),
    ],
)
def test_a_number_that_is_none_is_an_error_that_names_the_element(
    number: str, other: str, message: str
) -> None:
    assert number in ARM
    with pytest.raises(OptionError, match=message.replace("+", "[+]")):
        read_mjcf(ARM.replace(number, other))


@pytest.mark.parametrize("limits", ["", 'range="0 0"', 'range="1 -1" limited="false"'])
def test_a_joint_may_have_no_limits(limits: str) -> None:
    (elbow,) = [
        each for each in read_mjcf(ARM.replace('range="-90 45"', limits)).joints if each.moves
    ]
    assert (elbow.low, elbow.high) == (-float("inf"), float("inf"))


@pytest.mark.parametrize("source", [None, 3, Path(__file__).parent])
def test_what_is_neither_a_file_nor_a_text_is_an_error(source: Any) -> None:
    with pytest.raises(OptionError, match="expected a file"):
        read_mjcf(source)


@pytest.mark.parametrize(
    "bomb",
    [
        '<worldbody><replicate count="10000000" offset="0 0 1"><geom size="1"/></replicate>',
        '<asset><hfield name="h" nrow="100000" ncol="100000" size="1 1 1 1"/></asset><worldbody>',
        '<size nuserdata="1000000000"/><worldbody>',
    ],
)
def test_what_stands_for_very_much_is_an_error(bomb: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compilation, "MOST_TIME", 1)
    with pytest.raises(OptionError, match="MuJoCo (cannot compile|does not accept) The text"):
        read_mjcf(ARM.replace("<worldbody>", bomb))


def test_what_mujoco_has_against_a_file_is_told(tmp_path: Path) -> None:
    file = tmp_path / "arm.xml"
    file.write_text(ARM.replace("elbow", "tip").replace("<geom", "<cone"))
    with pytest.raises(OptionError, match="does not accept .*arm.xml: .*unrecognized element"):
        read_mjcf(file)
