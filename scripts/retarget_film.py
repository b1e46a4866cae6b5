"""A film of `retarget.py`: one reference, followed by a sum, a projection and the steepest path.

The arms are seen from the side, without exploration; the wall has three times the slope of a point.

Example: python scripts/retarget_film.py --out runs/retarget/retarget.webp
"""

import argparse
from collections.abc import Iterator

import numpy as np
import torch
from matplotlib.figure import Figure

from aicon_baselines.cli.command_line import Command, add_option, at_least, run_command
from aicon_baselines.figures.rendering import Frame, render
from aicon_baselines.palette import OBSTACLE, PALE, ROBOT, TARGET
from film import add_film, save_film
from retarget import BEHIND, DIPS
from retarget_world import DT, Array, follow, make_policy, offsets, panda, points_of, references
from rule_study import RULES

SHOWN = ("sum", "projection", "steepest path")
POINTS, SLOPE, SECONDS = 8, 3.0, 8.0
EVERY = 5  # steps from a frame to the next


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is shown, and where it is saved."""
    add_option(parser, "--seed", 1000, "of the reference", type=at_least(0))
    add_film(parser, "runs/retarget/retarget.webp")


def run(arguments: argparse.Namespace) -> None:
    """Let every rule follow the reference, and film them beside each other."""
    joints, points = references(POINTS, 1, SECONDS, arguments.seed)
    wall = np.quantile(points[..., 0].max(-1), 1.0 - DIPS, axis=0)[:, None]
    slope = np.full((1, 1), SLOPE)
    paths = {
        rule: follow(make_policy(RULES[rule], POINTS), joints, points, wall, slope)[2][:, 0]
        for rule in SHOWN
    }

    frames = draw(joints[:, 0], paths, float(wall[0, 0]))
    save_film(frames, arguments.out, DT * EVERY)


def draw(reference: Array, paths: dict[str, Array], wall: float) -> Iterator[Frame]:
    """A panel for each rule: its arm and the reference, of joints ``(steps, 7)``, rad."""
    figure = Figure(figsize=(8.4, 2.5), dpi=80, layout="constrained")
    (panels,) = figure.subplots(1, len(paths), sharex=True, sharey=True, squeeze=False)
    aim_links, aim = shape(reference)
    shapes = {rule: shape(path) for rule, path in paths.items()}

    for step in range(0, len(reference), EVERY):
        for axes, (rule, (links, points)) in zip(panels, shapes.items(), strict=True):
            axes.clear()
            axes.axvspan(wall, wall + 0.3, color=OBSTACLE, alpha=0.25, linewidth=0)
            axes.plot(*aim_links[step].T, color=PALE, linewidth=2, alpha=0.6)
            axes.plot(*aim[step].T, "o", color=PALE, markersize=3)

            axes.plot(*links[step].T, color=ROBOT, linewidth=4, solid_capstyle="round")
            is_behind = points[step, :, 0] > wall + BEHIND
            for place, color in zip(points[step], np.where(is_behind, TARGET, ROBOT), strict=True):
                axes.plot(*place, "o", color=color, markersize=4)

            depth = max(0.0, float(points[step, :, 0].max()) - wall)
            axes.set_title(f"{rule}: {100 * depth:.1f} cm behind the wall", fontsize=9)
            axes.set(xlim=(-0.45, wall + 0.15), ylim=(-0.02, 0.95), aspect="equal")
            axes.set(xticks=[], yticks=[])
        yield render(figure)


def shape(path: Array) -> tuple[Array, Array]:
    """Links ``(steps, 9, 2)`` and points ``(steps, N, 2)`` of an arm from the side, m."""
    frames = panda().frames(torch.from_numpy(path))
    base = np.zeros((len(path), 1, 3))
    links = np.concatenate((base, frames[..., :3, 3].numpy()), axis=1)
    points = points_of(frames, offsets(POINTS)).numpy()
    return links[..., [0, 2]], points[..., [0, 2]]


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
