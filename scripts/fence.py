"""When projection matters: a robot follows N leaders that drive on the other side of a fence.

The robot knows where it is, and where the leaders are. It is to be near each of them, and not to
cross the fence; all leaders drive along it, 1 m behind it. Rule, number of leaders and slope of the
fence's cost are varied, and nothing else. What is counted is how many of the starts ever lead to
more than 5 cm behind the fence, and how far from the leaders the robot is.

Example: python scripts/fence.py --out runs/fence
"""

import argparse
from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from aicon_baselines.cli.command_line import RESUMABLE, Command, add_option, run_command
from aicon_baselines.evaluation.tables import to_markdown
from aicon_torch import (
    ActionLaw,
    Actuator,
    Deterministic,
    DirectDescent,
    Foresight,
    Goal,
    Interconnection,
    Policy,
    Sensor,
    WorldModel,
)
from rule_study import RULES
from study_table import fill

DT = 0.02  # s
SPEED = 1.0  # m/s, of the robot; the leaders drive at half of it
SLACK = 0.02  # m, below which being near a leader is worth less and less
MARGIN = 0.1  # m, how far before the fence its cost begins
BEHIND = 0.05  # m, from where on the fence counts as crossed
LEADERS = (1, 2, 4, 8, 16)
STARTS, SECONDS = 20, 10.0  # of each cell, and of an episode
LAWS: dict[str, ActionLaw] = {"one gradient": DirectDescent(), "foresight": Foresight()}
"""One gradient at each reading, or many on the model's prediction."""

SLOPES = (0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0)


class Cell(NamedTuple):
    """What came of one rule with so many leaders and one slope.

    Attributes:
        crossed: How many of STARTS led across.
        lag: Mean distance to the leaders along the fence in the last second, m.
    """

    rule: str
    law: str
    leaders: int
    slope: float
    starts: int
    crossed: int
    lag: float


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare where it is saved."""
    add_option(parser, "--out", Path("runs/fence"), "folder of the results")


def run(arguments: argparse.Namespace) -> None:
    """Try every rule, save a row for each cell as it comes, and draw them."""
    torch.set_num_threads(1)
    wanted = [(rule, law, count) for law in LAWS for rule in RULES for count in LEADERS]
    cells = fill(arguments.out / "cells.csv", Cell, wanted, follow)

    for law in LAWS:
        print(f"\n{law}: the least slope that keeps all {STARTS} starts on this side\n")
        lines = [
            [rule, *(least_slope(cells, rule, law, count) for count in LEADERS)] for rule in RULES
        ]
        print(to_markdown(["leaders", *map(str, LEADERS)], lines))
    draw(cells, arguments.out / "fence.png")
    print(f"\nsaved in {arguments.out}: cells.csv, fence.png")


def make_policy(rule: str, law: str, count: int) -> Policy:
    """A robot with so many leaders, whose fence's slope is read like everything else."""

    def place(z: Tensor, x: Tensor) -> Tensor:
        return z + x

    def gap(z_leader: Tensor, x: Tensor) -> Tensor:
        return z_leader - x

    def nearness(leader: Tensor) -> Tensor:
        return (leader.square().sum(-1) + SLACK**2).sqrt()

    def crossing(position: Tensor, z_slope: Tensor) -> Tensor:
        return z_slope[..., 0] * torch.relu(position[..., 1] + MARGIN)

    sensors = {"z": Sensor(2, "m"), "z_slope": Sensor(1, "1")}
    estimators = [
        Deterministic("x", Interconnection(lambda v, dt: v * dt, ["v", "dt"]), is_motion=True),
        Deterministic("position", place),
    ]
    goals = [Goal("fence", crossing)]
    for index in range(count):
        reading, leader = f"z_leader_{index}", f"leader_{index}"
        sensors[reading] = Sensor(2, "m")
        estimators.append(Deterministic(leader, Interconnection(gap, [reading, "x"])))
        goals.append(Goal(f"follow {index}", Interconnection(nearness, [leader])))

    actuators = {"v": Actuator(2, "m/s", limit=SPEED)}
    model = WorldModel(
        sensors=sensors, actuators=actuators, estimators=estimators, goals=goals, dt=DT
    )
    return Policy(model, RULES[rule], LAWS[law]).compile()


def follow(rule: str, law: str, count: int) -> list[Cell]:
    """Every slope and every start at once, as rows of one batch."""
    policy = make_policy(rule, law, count)
    robot, leaders = starts(count)
    slopes = np.repeat(SLOPES, STARTS)[:, None]
    robot, leaders = np.tile(robot, (len(SLOPES), 1)), np.tile(leaders, (len(SLOPES), 1, 1))

    highest, lags, memory = robot[:, 1], [], None
    steps = round(SECONDS / DT)
    for step in range(steps):
        observation = {"z": robot, "z_slope": slopes}
        for index in range(count):
            observation[f"z_leader_{index}"] = leaders[:, index] - robot
        velocity, memory = policy.predict(observation, memory)

        robot = robot + velocity * DT
        leaders = leaders + np.array([0.5 * SPEED * DT, 0.0])
        highest = np.maximum(highest, robot[:, 1])
        if step >= steps - round(1.0 / DT):
            lags.append(np.abs(leaders[..., 0].mean(1) - robot[:, 0]))

    crossed = (highest > BEHIND).reshape(len(SLOPES), -1).sum(1)
    lag = np.mean(lags, axis=0).reshape(len(SLOPES), -1).mean(1)
    told = zip(SLOPES, crossed.tolist(), lag.tolist(), strict=True)
    return [Cell(rule, law, count, s, STARTS, c, round(m, 4)) for s, c, m in told]


def starts(count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Where robots ``(STARTS, 2)`` and leaders ``(STARTS, count, 2)`` begin, m."""
    generator = np.random.default_rng([300_000, count])
    robot = generator.uniform((-1.0, -1.5), (1.0, -0.5), (STARTS, 2))
    leaders = generator.uniform((-0.5, 0.8), (0.5, 1.2), (STARTS, count, 2))
    return robot, leaders


def least_slope(cells: list[Cell], rule: str, law: str, count: int) -> str:
    """The least slope from which on no start leads across; "none" where there is none."""
    own = [cell for cell in cells if (cell.rule, cell.law, cell.leaders) == (rule, law, count)]
    highest = max((cell.slope for cell in own if cell.crossed), default=0.0)
    holding = [cell.slope for cell in own if cell.slope > highest]
    return f"{min(holding):g}" if holding else "none"


def draw(cells: list[Cell], path: Path) -> None:
    """The share that crosses, over leaders and slope, a panel for each rule and law."""
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(
        len(LAWS), len(RULES), figsize=(12, 5.2), sharex=True, sharey=True, layout="constrained"
    )
    for row, law in enumerate(LAWS):
        for column, rule in enumerate(RULES):
            shares = np.full((len(SLOPES), len(LEADERS)), np.nan)
            for cell in cells:
                if (cell.rule, cell.law) == (rule, law):
                    place = SLOPES.index(cell.slope), LEADERS.index(cell.leaders)
                    shares[place] = cell.crossed / cell.starts

            panel = panels[row, column]
            image = panel.imshow(shares, "RdYlGn_r", origin="lower", aspect="auto", vmin=0, vmax=1)
            panel.set_title(f"{rule}, {law}", fontsize=9)
            panel.set_xticks(range(len(LEADERS)), LEADERS)
            panel.set_yticks(range(len(SLOPES)), [f"{slope:g}" for slope in SLOPES])
    figure.supxlabel("leaders behind the fence")
    figure.supylabel("slope of the fence's cost (a leader's is 1)")
    figure.colorbar(image, ax=panels, label="share of the starts that cross it")
    figure.savefig(path, dpi=150)


COMMAND = Command(__doc__, add_arguments, run, RESUMABLE)

if __name__ == "__main__":
    run_command(COMMAND)
