"""Python in the documents: what is complete runs, and the rest is Python.

A block of ```python that imports something is a program. Fragments import nothing, or are ```py.
In a tutorial, and on the first page, the blocks follow on each other: test_tutorials.py.
"""

import contextlib
import importlib.util
import io
from typing import Any

import pytest
from _documents import Block, all_blocks

BLOCKS = [
    block
    for block in all_blocks("python")
    if block.document.parent.name != "tutorials" and block.document.name != "start.md"
]
ELSEWHERE = "aicon_envs.reach"  # README's arm takes a while: tests/models/reach/test_readme.py
PROGRAMS = [block for block in BLOCKS if "import " in block.code and ELSEWHERE not in block.code]
FRAGMENTS = [block for block in BLOCKS if "import " not in block.code] + all_blocks("py")

LONG = ("aicon/ArmPush", "aicon/PushT", "Capsules.from_urdf", "Robot.from_urdf")
"""What takes a while: a program with one of these runs with the slow tests."""

NEEDED = {
    "aicon/PushT": "pymunk",
    "aicon/ArmPush": "trimesh",
    "Chain.from_urdf": "pytorch_kinematics",
    "Capsules.from_urdf": "trimesh",
}


@pytest.mark.parametrize("block", FRAGMENTS, ids=str)
def test_a_fragment_is_python(block: Block) -> None:
    compile(block.code, str(block), "exec")


def marked(block: Block) -> Any:
    is_long = any(word in block.code for word in LONG)
    return pytest.param(block, marks=[pytest.mark.slow] * is_long, id=str(block))


@pytest.mark.parametrize("block", [marked(block) for block in PROGRAMS])
def test_a_program_runs(block: Block) -> None:
    for environment, module in NEEDED.items():
        if environment in block.code and importlib.util.find_spec(module) is None:
            pytest.skip(f"{module} is not installed")

    program = compile(block.code, str(block), "exec")
    with contextlib.redirect_stdout(io.StringIO()):
        exec(program, {"__name__": "__main__"})
