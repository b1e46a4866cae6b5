"""docs/memory.md lists the memory of every preset."""

import re
from pathlib import Path

import numpy as np
from _inputs.reaching import planar_arm

from aicon_torch import Policy, Shield, make_policy, presets
from aicon_torch.control.memory import memory_shapes
from aicon_torch.dampers import PlaceEscape
from aicon_torch.models.reach import Options, body_model

PAGE = Path(__file__).parents[2] / "docs" / "memory.md"


def rows() -> dict[str, int]:
    """The keys of the page with the number of their dimensions besides the batch's."""
    found: dict[str, int] = {}
    for key, shape in re.findall(r"^\| `(.+?)` \| `\(\*B(.*?)\)` \|", PAGE.read_text(), re.M):
        found[key] = shape.count(",")
    return found


def policies() -> list[Policy]:
    """Those of all presets, two with an option that no preset has, and a shield's."""
    gives_up = {"robot": planar_arm(), "dampers.escape": PlaceEscape(gives_up=8)}
    found: list[Policy] = [
        make_policy("nav2d", **{"resolution.exploration.escape.onward": True}),
        make_policy("reach", **gives_up),
    ]
    found.append(
        Shield(lambda observation: np.zeros(3), body_model(Options(robot=planar_arm()))).policy
    )
    for task in ("nav2d", "pusht", "arm_push", "reach"):
        options = {"robot": planar_arm()} if task == "reach" else {}
        found.extend(make_policy(task, preset=preset, **options) for preset in presets(task))
    return found


def row_of(policy: Policy, key: str) -> str:
    """The row of the page that a key of a memory falls under."""
    model = policy.model
    kinds = {"sensor": model.sensors, "actuator": model.actuators, "quantity": model.quantities}
    matches: list[str] = []
    for row in rows():
        kind = re.match(r"<(\w+)>", row)
        names = kinds[kind[1]] if kind else [""]
        rest = row[kind.end() :] if kind else row
        matches.extend(row for name in names if name + rest == key)
    assert len(matches) == 1, f"{key}: {matches}"
    return matches[0]


def test_the_page_lists_every_key_of_every_preset_and_no_other() -> None:
    used: set[str] = set()
    for policy in policies():
        for key, shape in memory_shapes(policy.backward_pass, policy._step.validate).items():
            row = row_of(policy, key)
            used.add(row)
            assert row == "<quantity>" or rows()[row] == len(shape), key
    assert used == set(rows())
