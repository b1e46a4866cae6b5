"""Count the numbers of a task's policy that somebody set by hand.

Example: python scripts/count_numbers.py

Other people's worlds, examples/worlds, follow those of the library, with the lines of their graphs:
those of the function that makes a graph and of all that it calls there, but for docstrings and what
reads a map. What is told there of a robot or a map is given.

A number is an option that is one, or each number of a tuple; each constant of a model that decides
how it behaves; and each of the safety layer where an actuator has dampers. What is switched off by
a 0, or serves an option that is, counts for nothing. What is not named below as given or privileged
counts as set by hand.
"""

import argparse
import sys
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from functools import reduce
from importlib import import_module
from typing import Any, NamedTuple

from aicon_baselines.cli.command_line import Command, run_command
from aicon_baselines.evaluation.tables import to_markdown
from aicon_torch.control import Foresight
from aicon_torch.models.factory import MODELS
from aicon_torch.resolution import NullspaceProjection
from aicon_torch.safety import bounds, known_places, place_search, places, task_cost
from graph_code import WORLDS, functions_of, is_model, lines_of, options_of


class Graph(NamedTuple):
    """A graph of other people's worlds.

    Attributes:
        module: Where it is made.
        maker: The function that makes it of options.
        constants: What is set by hand beside its options.
        told: Options that say what there is.
    """

    module: str
    maker: str = "build"
    constants: tuple[str, ...] = ()
    told: tuple[str, ...] = ()


def picking(module: str, *constants: str) -> Graph:
    """A graph that picks up: told are how large a block is, and how well it is read."""
    return Graph(module, constants=constants, told=("size", "noise"))


AT_ONCE = "meta_world.AT_ONCE"
HEIGHT = "so101_pick_place.HAND.height"

GRAPHS = {
    "PointMaze": Graph("pointmaze"),
    "OGBench's mazes": Graph("ogbench_mazes"),
    "A crowd": Graph("crowd"),
    "FetchReach": Graph("fetch", "reach"),
    "FetchPush": Graph("fetch", "push"),
    "Meta-World: hand": Graph("meta_world", constants=(AT_ONCE,)),
    "Meta-World: puck": picking(
        "meta_world_puck", AT_ONCE, "meta_world_puck.EFFORT", "meta_world_puck.HAND.speed"
    ),
    "SO-101: pick and place": picking("so101_pick_place", HEIGHT),
    "SO-101: pick-cube": picking("so101_pick_place", HEIGHT, "so101_pick_cube.LIFT"),
    "SO-101: by its joints": picking(
        "so101_by_joints",
        HEIGHT,
        "so101_pick_cube.LIFT",
        *(f"so101_by_joints.{name}" for name in ("SPEED", "LEVER", "WORTH", "DAMPING")),
    ),
    "SO-101: in the way": picking(
        "so101_in_the_way",
        HEIGHT,
        *(f"so101_in_the_way.{name}" for name in ("LENGTH", "NEGLIGIBLE", "WORTH")),
    ),
    "OGBench's cubes": picking("ogbench_cubes"),
    "OGBench: scene": picking("ogbench_scene", "ogbench_scene.ASIDE", "ogbench_scene.DOWN"),
}
"""Other people's worlds, in examples/worlds."""

MAPS = ("walls_of",)
"""What reads a map there, which is told."""

GIVEN = frozenset(
    {
        # The robot, its sensors and the task.
        *("dt", "max_speed", "speed", "robot", "ball_radius", "people"),
        *("goal_pose", "corners", "axis", "contact.size", "pose_offset"),
        # Variances, of readings and of what is not modelled.
        *("bearing_noise", "range_noise", "actuation_noise", "keypoint_noise"),
        *("pose_noise", "drift", "camera.noise"),
        # So large that only the limits count.
        "law.gain",
    }
)
"""Options that describe what there is, and decide nothing about the behaviour."""

PRIVILEGED = frozenset({"expected_place", "height", "options.REACTION", "stick_friction"})
"""Options and constants that hold the simulation's own numbers: where the object starts, half its
thickness, the servos' time constant, the friction at the stick."""

CONSTANTS: dict[str, dict[str, tuple[str, ...]]] = {
    "nav2d": {"graph": ("COLLISION_LENGTH", "TARGET_DISTANCE", "TARGET_DISTANCE_DEVIATION")},
    "arm_push": {
        "options": ("REACTION",),
        "limits": ("TIP_SPEED", "JOINT_SPEED", "SETTLING_TIME"),
        "perception": ("TRUSTED_SCORE",),
        "pushed_object": ("SIDE_FORCE", "SIDE_DEVIATION", "TOP_FORCE", "TOP_DEVIATION"),
    },
    "reach": {"body": ("BALL_DISTANCE",)},
}
"""Constants of each model that nobody has to set, by module: set by hand all the same."""

SERVES = {
    "resolution.exploration.escape.progress_margin": "resolution.exploration.escape.progress",
    "resolution.exploration.escape.hold_gain": "resolution.exploration.escape.hold",
}
"""Options that count where another is set."""


NO_LIMIT = frozenset({"FARTHEST", "ROUNDING"})
"""Constants that are so large, or so small, that nothing depends on them."""


class Numbers(NamedTuple):
    """How many numbers there are, by option."""

    shared: dict[str, int]
    by_hand: dict[str, int]
    privileged: dict[str, int]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """There are none."""


def run(arguments: argparse.Namespace) -> None:
    """Print a row for each task, and one for each of the worlds of others."""
    rows = []
    for task in MODELS:
        rows.append([task, *map(in_words, numbers_of(task))])

    print(to_markdown(["task", "as in all tasks", "set by hand", "privileged"], rows))

    rows = []
    for world, graph in GRAPHS.items():
        lines = [str(count) for count in lines_of_graph(graph)]
        rows.append([world, *lines, *map(in_words, numbers_of_graph(graph))])
    named = ["world", "lines of its graph", "of a model", "set by hand", "in the model, for all"]
    print(to_markdown(named, rows))


def lines_of_graph(graph: Graph) -> tuple[int, int]:
    """Count the lines of one of the worlds of others: its own, and those of the library's model."""
    functions = functions_of(graph.module, graph.maker, without=MAPS)
    own = [function for function in functions if not is_model(function.module)]
    return lines_of(own), lines_of(functions) - lines_of(own)


def numbers_of_graph(graph: Graph) -> tuple[dict[str, int], dict[str, int]]:
    """Count the numbers that are set by hand in one of the worlds of others.

    Returns:
        Its own, and those of the library's model, which all of its worlds share.
    """
    if str(WORLDS) not in sys.path:
        sys.path.insert(0, str(WORLDS))
    options = import_module(graph.module).Options
    used = options_of(functions_of(graph.module, graph.maker))
    numbers = {}
    for name, count in numbers_in(options()).by_hand.items():
        if name.split(".")[0] in used and name not in graph.told:
            numbers[name] = count

    constants = {}
    for constant in graph.constants:
        module, *path = constant.split(".")
        constants[constant] = how_many(reduce(getattr, path, import_module(module)))
    if is_model(options.__module__):
        return constants, numbers
    return numbers | constants, {}


def numbers_of(task: str) -> Numbers:
    """Count the numbers of the policy that is shipped for a task."""
    options = import_module(MODELS[task]).Options()
    numbers = numbers_in(options)

    for module, names in CONSTANTS.get(task, {}).items():
        constants = vars(import_module(f"{MODELS[task]}.{module}"))
        for constant in names:
            name = f"{module}.{constant}"
            kind = numbers.privileged if name in PRIVILEGED else numbers.by_hand
            parts = leaves(name, constants[constant])
            kind.update({part: how_many(value) for part, value in parts})
    if any(name.startswith("dampers") for name, _ in leaves("", options)):
        numbers.by_hand.update(safety_constants())
    return numbers


def numbers_in(given: Any) -> Numbers:
    """Count the numbers of options."""
    options = dict(leaves("", given))
    shared = dict(leaves("resolution", NullspaceProjection())) | dict(leaves("law", Foresight()))

    numbers = Numbers({}, {}, {})
    for name, value in options.items():
        count = how_many(value)
        serves_nothing = name in SERVES and options[SERVES[name]] is None
        if count == 0 or name in GIVEN or serves_nothing:
            continue
        if name in PRIVILEGED:
            numbers.privileged[name] = count
        elif shared.get(name) == value and name not in SERVES:
            numbers.shared[name] = count
        else:
            numbers.by_hand[name] = count
    return numbers


def safety_constants() -> dict[str, int]:
    """The constants by which gaps are kept, and by which an actuator that is stuck comes free."""
    constants: dict[str, int] = {}
    for module in (bounds, places, place_search, known_places, task_cost):
        for name, value in vars(module).items():
            is_number = isinstance(value, int | float) and not isinstance(value, bool)
            if name.isupper() and is_number and name not in NO_LIMIT:
                constants[f"safety.{name}"] = 1
    return constants


def leaves(name: str, value: Any) -> Iterator[tuple[str, Any]]:
    """The options within an option, by dotted name."""
    if not is_dataclass(value) or name in GIVEN:
        yield name, value
        return
    for option in fields(value):
        yield from leaves(f"{name}.{option.name}".lstrip("."), getattr(value, option.name))


def how_many(value: Any) -> int:
    """How many numbers a value holds; whole ones say how often, and 1 is what goes without."""
    if isinstance(value, tuple):
        return len(value) if any(value) else 0
    if type(value) is int:
        return int(value > 1)
    return int(isinstance(value, float) and value != 0)


def in_words(numbers: dict[str, int]) -> str:
    """Their sum and their names, such as "3: `lever`, `expected_place` (2)"."""
    names = []
    for name, count in numbers.items():
        names.append(f"`{name}`" if count == 1 else f"`{name}` ({count})")
    return f"{sum(numbers.values())}: {', '.join(names)}" if names else "0"


COMMAND = Command(__doc__, add_arguments, run)

if __name__ == "__main__":
    run_command(COMMAND)
