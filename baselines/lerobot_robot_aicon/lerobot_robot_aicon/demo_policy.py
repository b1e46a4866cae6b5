"""A policy to try a shield with: an untrained network that asks for a posture in the table.

Example: python -m lerobot_robot_aicon.demo_policy runs/into_the_table
"""

import argparse
from pathlib import Path

import numpy as np
import torch
from lerobot.configs.types import FeatureType, PolicyFeature
from lerobot.policies.factory import get_policy_class, make_pre_post_processors
from numpy.typing import NDArray

from lerobot_robot_aicon.arm_options import ArmOptions, described_arm

GRIPPER_OPEN = 50.0


def posture_in_the_table(urdf: str = "so101") -> NDArray[np.float32]:
    """The joints ``(n,)``, degrees, of a posture whose tip is 5 cm and more below the base."""
    chain = described_arm(ArmOptions(urdf=urdf)).chain
    generator = torch.Generator().manual_seed(2)
    shares = torch.rand(200, len(chain.names), generator=generator, dtype=torch.float64)
    postures = chain.low + shares * (chain.high - chain.low)
    below = torch.nonzero(chain(postures)[:, 2, 3] < -0.05)
    found: NDArray[np.float32] = torch.rad2deg(postures[below[0, 0]]).float().numpy()
    return found


def write_policy(folder: Path) -> None:
    """Write a policy of an SO-101 with its gripper, which reads the motors and no picture.

    Raises:
        ValueError: If LeRobot is too old to have such a network.
    """
    try:
        from lerobot.policies.gaussian_actor.configuration_gaussian_actor import GaussianActorConfig
    except ModuleNotFoundError as error:
        raise ValueError("It takes LeRobot 0.6 or newer, and Python 3.12.") from error

    posture = torch.from_numpy(posture_in_the_table())
    motors = torch.cat((posture, torch.tensor([GRIPPER_OPEN])))
    size = (len(motors),)
    config = GaussianActorConfig(
        input_features={"observation.state": PolicyFeature(FeatureType.STATE, size)},
        output_features={"action": PolicyFeature(FeatureType.ACTION, size)},
        device="cpu",
        push_to_hub=False,
    )
    get_policy_class("gaussian_actor")(config).save_pretrained(folder)

    # Its actions, -1 to 1, lie within one degree of that posture.
    statistics = {
        "observation.state": {"min": torch.full(size, -180.0), "max": torch.full(size, 180.0)},
        "action": {"min": motors - 1, "max": motors + 1},
    }
    for processor in make_pre_post_processors(config, dataset_stats=statistics):
        processor.save_pretrained(folder)


def main() -> None:
    """Write it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="where to write it")
    arguments = parser.parse_args()
    try:
        write_policy(arguments.folder)
    except ValueError as error:
        parser.error(str(error))
    print(f"saved {arguments.folder}: --policy.path={arguments.folder}")


if __name__ == "__main__":
    main()
