"""How an arm stands, as it is described, while it is moved by hand: its motors do not hold it.

Example:
    python -m lerobot_robot_aicon.standing --robot.inner.type=aicon_simulated --robot.urdf=so101
"""

import importlib
import pkgutil
import time
from contextlib import suppress
from dataclasses import dataclass

import draccus
import lerobot.robots
import numpy as np
import torch
from lerobot.robots import make_robot_from_config

from lerobot_robot_aicon.arm_options import described_arm
from lerobot_robot_aicon.config_aicon_shield import AiconShieldConfig
from lerobot_robot_aicon.motors import Motors

# The command line knows the robots whose modules are imported; some of them need more packages.
for module in pkgutil.iter_modules(lerobot.robots.__path__):
    with suppress(ImportError):
        importlib.import_module(f"lerobot.robots.{module.name}")


@dataclass
class Standing:
    """Which arm.

    Attributes:
        robot: The arm, with the options that it has behind a shield.
        duration: How long it is looked at, s.
    """

    robot: AiconShieldConfig
    duration: float = 60.0


@draccus.wrap()  # type: ignore[misc]  # it has no types
def main(config: Standing) -> None:
    """Print what the motors show, what that is by the description, and where the tip is."""
    robot = make_robot_from_config(config.robot.inner)
    chain = described_arm(config.robot).chain
    motors = Motors(chain.names, config.robot)
    low, high = np.degrees(chain.low.numpy()), np.degrees(chain.high.numpy())

    robot.connect()
    try:
        if hasattr(robot, "bus"):
            robot.bus.disable_torque()
        end = time.monotonic() + config.duration
        while time.monotonic() < end:
            observation = robot.get_observation()
            q = motors.read(observation)
            print(f"\n{'joint':>16} {'motor':>8} {'described':>10}   stops, degrees")
            for name, key, angle, *stops in zip(
                chain.names, motors.keys, np.degrees(q), low, high, strict=True
            ):
                beyond = "" if stops[0] <= angle <= stops[1] else "  BEYOND"
                print(
                    f"{name:>16} {observation[key]:>8.1f} {angle:>10.1f}   "
                    f"{stops[0]:.0f} to {stops[1]:.0f}{beyond}"
                )
            x, y, z = (100 * chain(torch.from_numpy(q))[:3, 3]).tolist()
            print(f"the tip is {x:.1f} cm ahead, {y:.1f} cm left and {z:.1f} cm up of the base")
            time.sleep(1.0)
    except KeyboardInterrupt:
        print()
    finally:
        robot.disconnect()


if __name__ == "__main__":
    main()
