"""What a user waits for without anything running costs no import that only running needs."""

import subprocess
import sys

import pytest

HEAVY = ("torch", "matplotlib", "scipy.stats", "viser")
PROGRAM = f"""
import sys
from aicon_baselines.cli.main import main
try:
    main(sys.argv[1:])
except SystemExit as end:
    assert end.code in (0, 2), end.code
print("loaded:", *[name for name in {HEAVY} if name in sys.modules])
"""


@pytest.mark.parametrize(
    "words",
    [
        "--help",
        "--version",
        "list",
        "run --help",
        "watch --help",
        "compare --help",
        "diagnose --help",
        "figures nav2d --help",
        "bench --help",
        "export --help",
        "run --task fly",
        "watch fly",
        "compare --task fly --policies aicon --out nowhere",
    ],
)
def test_help_lists_and_mistakes_load_neither_torch_nor_what_draws(words: str) -> None:
    command = [sys.executable, "-c", PROGRAM, *words.split()]
    result = subprocess.run(command, capture_output=True, text=True, check=True)
    assert result.stdout.endswith("loaded:\n"), result.stdout[-200:]
