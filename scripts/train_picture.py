"""Train the network that sees pushT's object in pictures of 96 × 96, with shapes and covers in it.

Example: python scripts/train_picture.py --out baselines/checkpoints/pusht_picture.pt
         aicon compare --task pusht --policies aicon --conditions pixels pixels_covered --out runs/p

First it draws pictures of objects anywhere, then it learns from them: most have up to three boxes
and ellipses drawn into them. The same command goes on where it was stopped, and with more
steps with what is done. Fifteen minutes of one core.
"""

import argparse
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aicon_baselines.cli.command_line import RESUMABLE, Command, run_command

BATCH, RATE = 48, 2e-3
SEED = 1000
SAVED_EVERY = 100
WORK = ".training"
"""Suffixes of what is needed to go on: beside the weights, until they are done."""

CORNER_UNIT = 0.01
"""Error of a corner from which on it counts linearly, m."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare how much is drawn and learned."""
    parser.add_argument("--pictures", type=int, default=8_000, help="pictures (default: 8000)")
    parser.add_argument("--steps", type=int, default=5_200, help="of 48 pictures (default: 5200)")
    parser.add_argument("--out", type=Path, required=True, help="file of the weights")


def run(arguments: argparse.Namespace) -> None:
    """Draw what is missing, train, and say how good it is on pictures that it has not seen."""
    folder = arguments.out.with_suffix(WORK)
    folder.mkdir(parents=True, exist_ok=True)
    pictures, poses = draw_pictures(folder, arguments.pictures)
    train(pictures, poses, folder, arguments)


def draw_pictures(folder: Path, count: int) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
    """Pictures ``(count, 96, 96, 3)`` and frames of the object ``(count, 3)``, px and rad."""
    from tqdm import tqdm

    from aicon_envs.pusht import DEFAULT_GOAL, OBJECTS, Goal
    from aicon_envs.pusht.geometry import place
    from aicon_envs.pusht.rendering import draw_observation
    from aicon_envs.pusht.simulation import Simulation

    shape = (count, 96, 96, 3)
    open_memmap: Any = np.lib.format.open_memmap  # numpy leaves it untyped
    mode: Any = "r+" if (folder / "pictures.npy").exists() else "w+"
    pictures = open_memmap(folder / "pictures.npy", mode, np.uint8, shape)
    poses = open_memmap(folder / "poses.npy", mode, np.float64, (count, 3))

    tee = OBJECTS["T"]
    goal = Goal(tee, DEFAULT_GOAL)
    for number in tqdm(range(count), desc="pictures", disable=None):
        if poses[number].any():  # drawn before it was stopped
            continue
        generator = np.random.default_rng([SEED, number])
        while True:
            x, y = generator.uniform(0.0, 512.0, 2)
            pose = (x, y, generator.uniform(-math.pi, math.pi))
            outline = place(tee.outline, pose)
            if outline.min() > 0.0 and outline.max() < 512.0:
                break
        beside = outline[generator.integers(len(outline))] + generator.normal(0.0, 40.0, 2)
        anywhere = generator.uniform(15.0, 497.0, 2)
        pusher = beside if generator.uniform() < 0.5 else anywhere
        simulation = Simulation(tee, tuple(pusher.tolist()), pose)
        for moved in simulation.space.bodies:  # pymunk draws shapes where they were indexed
            simulation.space.reindex_shapes_for_body(moved)
        pictures[number] = draw_observation(simulation, goal, (96, 96))
        poses[number] = pose
    return pictures, poses


def cluttered(picture: NDArray[np.uint8], generator: np.random.Generator) -> NDArray[np.uint8]:
    """A picture with up to three small shapes, or with one or two that cover much of it."""
    from aicon_envs.pusht.clutter import random_box, random_colour

    drawn, kind = np.array(picture), generator.uniform()
    if kind < 0.3:
        return drawn
    count, largest = (generator.integers(1, 4), 0.25) if kind < 0.65 else (1, 0.9)
    for _ in range(count):
        drawn[random_box((96, 96), generator, largest)] = random_colour(generator)
    return drawn


def train(
    pictures: NDArray[np.uint8],
    poses: NDArray[np.float64],
    folder: Path,
    arguments: argparse.Namespace,
) -> None:
    """Train the network, from where it was stopped."""
    import torch
    from tqdm import tqdm

    from aicon_torch.models.pusht import PIXEL, Options, rigid_object
    from aicon_torch.models.pusht.picture import PoseNetwork

    torch.manual_seed(SEED)
    body = rigid_object(Options())
    network = PoseNetwork(body)
    optimizer = torch.optim.AdamW(network.parameters(), lr=RATE, weight_decay=1e-4)
    state, done = folder / "state.pt", 0
    if state.exists():
        saved = torch.load(state, weights_only=True)
        network.load_state_dict(saved["network"])
        optimizer.load_state_dict(saved["optimizer"])
        done = saved["done"]

    frames = torch.from_numpy(np.array(poses)) * torch.tensor([PIXEL, PIXEL, 1.0])
    true_poses = body.pose_of_frame(frames).float()
    held_out = len(pictures) // 20

    def batch(step: int, first: int, last: int) -> tuple[Any, Any]:
        generator = np.random.default_rng([SEED + 1, step])
        chosen = generator.integers(first, last, BATCH)
        drawn = np.stack([cluttered(pictures[number], generator) for number in chosen])
        return torch.from_numpy(drawn).movedim(-1, 1).float() / 255, true_poses[chosen]

    bar = tqdm(range(done, arguments.steps), desc="steps", disable=None)
    for step in bar:
        drawn, truth = batch(step, held_out, len(pictures))
        loss, error = _loss(network, drawn, truth)
        optimizer.param_groups[0]["lr"] = RATE * _share(step, arguments.steps)
        optimizer.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(network.parameters(), 1.0)
        optimizer.step()
        if (step + 1) % SAVED_EVERY == 0:
            message = f"{1000 * error.abs().median():.1f} mm"
            bar.set_postfix_str(message)
            print(step + 1, f"loss {loss.item():.2f}, median {message}", flush=True)
            saved = {"network": network.state_dict(), "optimizer": optimizer.state_dict()}
            torch.save({**saved, "done": step + 1}, state)
    torch.save(network.state_dict(), arguments.out)
    unseen = [batch(arguments.steps + number, 0, held_out) for number in range(8)]
    _report(network, unseen, PIXEL)


def _share(step: int, steps: int) -> float:
    """Of the learning rate: up in the first 200 steps, then down along a cosine."""
    return min(1.0, (step + 1) / 200) * 0.5 * (1 + math.cos(math.pi * step / steps))


def _loss(network: Any, pictures: Any, truth: Any) -> tuple[Any, Any]:
    """Corners by their distance, variances by the likelihood of the pose's error."""
    from torch.nn.functional import smooth_l1_loss

    from aicon_torch.parts.planar import pose_error

    seen, corners = network(pictures)
    wanted = network.body.keypoints_at(truth)
    of_corners = smooth_l1_loss(corners / CORNER_UNIT, wanted / CORNER_UNIT)

    # What the variances learn is how far the pose is off, not to move the pose.
    error, log_variances = pose_error(seen[..., :3], truth, 1.0).detach(), seen[..., 3:]
    of_variances = 0.5 * (error.square() / log_variances.exp() + log_variances)
    return of_corners + 0.1 * of_variances.clamp(max=1e3).mean(), error[..., :2]


def _report(network: Any, batches: list[tuple[Any, Any]], pixel: float) -> None:
    """How far it is off in pictures that it has not seen, and whether it knows."""
    import torch

    from aicon_torch.parts.planar import pose_error

    errors, log_variances = [], []
    with torch.no_grad():
        for pictures, truth in batches:
            seen, _ = network(pictures)
            errors.append(pose_error(seen[..., :3], truth, 1.0))
            log_variances.append(seen[..., 3:])
    error, log_variance = torch.cat(errors), torch.cat(log_variances)
    off = error[..., :2].norm(dim=-1) / pixel
    ratio = (error.square() / log_variance.exp()).mean(0)
    print(f"held out: median {off.median():.2f} px, mean {off.mean():.2f} px")
    print("chi² for each degree of freedom:", [round(x, 2) for x in ratio.tolist()])


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)

if __name__ == "__main__":
    run_command(COMMAND)
