"""Train the network that sees pushT's object in pictures, with shapes and covers in them.

Example: python scripts/train_picture.py --out baselines/checkpoints/pusht_picture/weights.pt
         aicon compare --task pusht --policies aicon --conditions pixels pixels_covered --out runs/p

First it draws pictures of objects anywhere, then it learns from them. Into most of them it draws
boxes and ellipses, or covers with a wavy outline and bands across. The same command goes on where
it was stopped. Ten minutes of one core.
"""

import argparse
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aicon_baselines.cli.command_line import RESUMABLE, Command, add_option, run_command
from aicon_baselines.evaluation.errors import ComparisonError, check_counts
from aicon_baselines.files import check_same_config, only_writer, read_json, replacing, write_json

BATCH, RATE = 64, 2e-3
SEED = 1000
SAVED_EVERY = 200
EXACT = 0.15
"""Share of the steps, the last ones, whose convolutions are in single precision, not in half."""

WORK = ".training"
"""Suffix of the folder with what is needed to go on, beside the weights."""

DRAWN = "drawn.json"
"""The file in it that says which pictures it holds."""

HELD_OUT = 20
"""One of so many pictures is not learned from, but looked at in the end."""

TRUSTED = 5.0
"""Largest error in standard deviations that a likelihood counts in full; beyond, it is linear."""

AROUND_GOAL = (30.0, 30.0, 0.4)
"""Standard deviations of every third pose about the goal, where it must be known best, px, rad."""

COLOURS = (
    *((119, 136, 153), (143, 163, 184)),  # the object's border, and the object
    *((65, 105, 225), (78, 126, 255)),  # the pusher's
    *((144, 238, 144), (255, 255, 255)),  # the goal, and nothing
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare how much is drawn and learned."""
    add_option(parser, "--pictures", 40_000, "pictures")
    add_option(parser, "--steps", 4_000, "of 64 pictures")
    add_option(parser, "--side", 96, "of a picture, pixels")
    parser.add_argument("--out", type=Path, required=True, help="file of the weights")


def run(arguments: argparse.Namespace) -> None:
    """Draw what is missing, train, and say how good it is on pictures that it has not seen."""
    check_counts(steps=arguments.steps, side=arguments.side)
    if arguments.pictures < HELD_OUT:
        raise ComparisonError(f"pictures must be {HELD_OUT} or more, not {arguments.pictures}")

    folder = arguments.out.with_suffix(WORK)
    with only_writer(folder):
        drawn = {"pictures": arguments.pictures, "side": arguments.side}
        if (folder / DRAWN).exists():
            check_same_config(folder, "other pictures", read_json(folder / DRAWN), drawn)
        write_json(folder / DRAWN, drawn)

        pictures, poses = draw_pictures(folder, arguments.pictures, arguments.side)
        train(pictures, poses, folder, arguments)


def draw_pictures(
    folder: Path, count: int, side: int
) -> tuple[NDArray[np.uint8], NDArray[np.float64]]:
    """Pictures ``(count, side, side, 3)`` and frames of the object ``(count, 3)``, px and rad."""
    from tqdm import tqdm

    from aicon_envs.pusht import DEFAULT_GOAL, OBJECTS, Goal
    from aicon_envs.pusht.geometry import place
    from aicon_envs.pusht.rendering import draw_observation
    from aicon_envs.pusht.simulation import Simulation

    shape = (count, side, side, 3)
    open_memmap: Any = np.lib.format.open_memmap  # numpy leaves it untyped
    mode: Any = "r+" if (folder / "poses.npy").exists() else "w+"  # the file that is begun last
    pictures = open_memmap(folder / "pictures.npy", mode, np.uint8, shape)
    poses = open_memmap(folder / "poses.npy", mode, np.float64, (count, 3))

    tee = OBJECTS["T"]
    goal = Goal(tee, DEFAULT_GOAL)
    for number in tqdm(range(count), desc="pictures", disable=None):
        if poses[number].any():  # drawn before it was stopped
            continue
        generator = np.random.default_rng([SEED, number])
        while True:
            near = generator.normal(DEFAULT_GOAL, AROUND_GOAL)
            anywhere = generator.uniform((0.0, 0.0, -math.pi), (512.0, 512.0, math.pi))
            pose = tuple((near if number % 3 == 0 else anywhere).tolist())
            outline = place(tee.outline, pose)
            if outline.min() > 0.0 and outline.max() < 512.0:
                break
        beside = outline[generator.integers(len(outline))] + generator.normal(0.0, 40.0, 2)
        afar = generator.uniform(15.0, 497.0, 2)
        pusher = beside if generator.uniform() < 0.5 else afar
        simulation = Simulation(tee, tuple(pusher.tolist()), pose)
        for moved in simulation.space.bodies:  # pymunk draws shapes where they were indexed
            simulation.space.reindex_shapes_for_body(moved)
        pictures[number] = draw_observation(simulation, goal, (side, side))
        poses[number] = pose
    return pictures, poses


def cluttered(picture: NDArray[np.uint8], generator: np.random.Generator) -> NDArray[np.uint8]:
    """A picture, with up to four shapes in it, with a cover, or with both."""
    import cv2

    drawn, kind = np.array(picture), generator.uniform()
    shapes = [_shape(generator) for _ in range(generator.integers(1, 5))] if kind < 0.45 else []
    if 0.35 < kind < 0.8:
        shapes.append(_cover(generator))
    for outline in shapes:
        pixels = np.round(outline * len(drawn)).astype(np.int32)
        cv2.fillPoly(drawn, [pixels], _colour(generator).tolist())
    return drawn


def _shape(generator: np.random.Generator) -> NDArray[np.float64]:
    """The outline of a turned box or ellipse, in sides of the picture."""
    corners = 4 if generator.uniform() < 0.5 else 24
    angles = 2 * math.pi * (np.arange(corners) + 0.5) / corners
    sides = generator.uniform(0.03, 0.16, (2, 1)) * np.stack((np.cos(angles), np.sin(angles)))
    return _placed(sides, generator)


def _cover(generator: np.random.Generator) -> NDArray[np.float64]:
    """The outline of a large cover, a wavy one or a band across, in sides of the picture."""
    if generator.uniform() < 0.3:
        band = np.array([[-2.0, 2.0, 2.0, -2.0], [-1.0, -1.0, 1.0, 1.0]])
        return _placed(band * [[1.0], [generator.uniform(0.05, 0.25)]], generator)
    angles = 2 * math.pi * np.arange(48) / 48
    orders = np.arange(1, 5)[:, np.newaxis]
    waves = np.sin(orders * angles + generator.uniform(0, 2 * math.pi, (4, 1)))
    radius = 1 + generator.uniform(0, 0.25, 4) @ waves
    size = generator.uniform(0.15, 0.5, (2, 1))
    return _placed(size * radius * np.stack((np.cos(angles), np.sin(angles))), generator)


def _placed(outline: NDArray[np.float64], generator: np.random.Generator) -> NDArray[np.float64]:
    """An outline ``(2, n)`` turned and moved to somewhere, ``(n, 2)``."""
    turn, place = generator.uniform(0, 2 * math.pi), generator.uniform(0, 1, 2)
    rotation = [[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]]
    placed: NDArray[np.float64] = outline.T @ np.array(rotation) + place
    return placed


def _colour(generator: np.random.Generator) -> NDArray[np.int64]:
    """Any colour ``(3,)``, or one like that of something in the world."""
    if generator.uniform() < 0.5:
        return generator.integers(0, 256, 3)
    like = np.array(COLOURS[generator.integers(len(COLOURS))])
    off = generator.normal(0.0, 12.0, 3) * (generator.uniform() < 0.5)
    return np.clip(like + off, 0, 255).astype(np.int64)


def train(
    pictures: NDArray[np.uint8],
    poses: NDArray[np.float64],
    folder: Path,
    arguments: argparse.Namespace,
) -> None:
    """Train the network, from where it was stopped."""
    import torch
    from torch.utils.data import DataLoader
    from tqdm import tqdm

    from aicon_torch.models.pusht import PIXEL, Options, rigid_object
    from aicon_torch.models.pusht.picture import PoseNetwork

    torch.manual_seed(SEED)
    body = rigid_object(Options())
    network: Any = PoseNetwork(body)  # torch types no formats
    network.to(memory_format=torch.channels_last)
    optimizer = torch.optim.AdamW(network.parameters(), lr=RATE, weight_decay=1e-4)
    state, done = folder / "state.pt", 0
    if state.exists():
        saved = torch.load(state, weights_only=True)
        network.load_state_dict(saved["network"])
        optimizer.load_state_dict(saved["optimizer"])
        done = saved["done"]

    frames = torch.from_numpy(np.array(poses)) * torch.tensor([PIXEL, PIXEL, 1.0])
    true_poses = body.pose_of_frame(frames).float()
    held_out = len(pictures) // HELD_OUT

    class Batches(torch.utils.data.Dataset[Any]):
        """The pictures and poses of each step, the same whenever it is drawn."""

        def __getitem__(self, step: int) -> tuple[Any, Any]:
            generator = np.random.default_rng([SEED + 1, step])
            is_test = step >= arguments.steps
            seen = (0, held_out) if is_test else (held_out, len(pictures))
            chosen = generator.integers(*seen, BATCH)
            drawn = np.stack([cluttered(pictures[number], generator) for number in chosen])
            return torch.from_numpy(drawn).movedim(-1, 1), true_poses[chosen]

    def batches(first: int, last: int) -> Any:
        steps = range(first, last)
        return DataLoader(Batches(), batch_size=None, sampler=steps, num_workers=1)

    bar = tqdm(batches(done, arguments.steps), desc="steps", disable=None)
    for step, (drawn, truth) in enumerate(bar, done):
        half = step < (1 - EXACT) * arguments.steps
        with torch.autocast("cpu", torch.bfloat16, enabled=half):
            features = network.features(drawn.float() / 255 - 0.5)
        loss, error = _loss(network.seen_in(features.float()), network.body, truth)
        optimizer.param_groups[0]["lr"] = RATE * _share(step, arguments.steps)
        optimizer.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(network.parameters(), 1.0)
        optimizer.step()
        if (step + 1) % SAVED_EVERY == 0:
            message = f"loss {loss.item():.2f}, median {error.abs().median() / PIXEL:.1f} px"
            bar.set_postfix_str(message)
            print(step + 1, message, flush=True)
            saved = {"network": network.state_dict(), "optimizer": optimizer.state_dict()}
            with replacing(state) as place:
                torch.save({**saved, "done": step + 1}, place)
    with replacing(arguments.out) as place:
        torch.save(network.state_dict(), place)
    _report(network, batches(arguments.steps, arguments.steps + 16), PIXEL)


def _share(step: int, steps: int) -> float:
    """Of the learning rate: up in the first 200 steps, then down along a cosine."""
    return min(1.0, (step + 1) / 200) * 0.5 * (1 + math.cos(math.pi * step / steps))


def _loss(sight: Any, body: Any, truth: Any) -> tuple[Any, Any]:
    """Negative log-likelihoods: of corners by their heatmaps and variances, of the pose by its."""
    from aicon_torch.parts.planar import pose_error

    corners = body.keypoints_at(truth)
    of_heatmaps = -(_splat(corners, sight.log_share) * sight.log_share).sum((-2, -1))
    off = sight.corners - corners
    of_corners = _surprise(off, sight.log_variances.unsqueeze(-1))
    error = pose_error(sight.pose[..., :3], truth, 1.0)
    of_pose = _surprise(error, sight.pose[..., 3:])
    return of_heatmaps.mean() + of_corners.mean() + of_pose.mean(), error[..., :2].detach()


def _surprise(error: Any, log_variance: Any) -> Any:
    """−log N(e; 0, σ²) without its constant, linear beyond some standard deviations."""
    from torch.nn.functional import huber_loss

    whitened = error * (-0.5 * log_variance).exp()
    zero = whitened.new_zeros(()).expand_as(whitened)
    return huber_loss(whitened, zero, delta=TRUSTED, reduction="none") + 0.5 * log_variance


def _splat(corners: Any, heatmaps: Any) -> Any:
    """Corners ``(B, K, 2)`` as shares of the four cells around them, ``(B, K, h, w)``."""
    from aicon_torch.models.pusht.picture import along

    height, width = heatmaps.shape[-2:]
    shares = []
    for place, cells in zip(corners.unbind(-1), (width, height), strict=True):
        centers = along(cells, heatmaps)
        away = (place.unsqueeze(-1) - centers).abs() / (centers[1] - centers[0])
        shares.append((1 - away).clamp(min=0.0))
    return shares[1].unsqueeze(-1) * shares[0].unsqueeze(-2)


def _report(network: Any, batches: Any, pixel: float) -> None:
    """How far it is off in pictures that it has not seen, and whether it knows."""
    import torch

    from aicon_torch.parts.planar import pose_error

    errors, log_variances = [], []
    with torch.no_grad():
        for pictures, truth in batches:
            seen = network(pictures.float() / 255).pose
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
