"""What a user waits for without anything running costs no import that only running needs."""

import subprocess
import sys

HEAVY = ("torch", "matplotlib", "scipy.stats", "viser")
PROGRAM = f"""
import sys
from aicon_baselines.cli.main import main
for words in sys.argv[1:]:
    try:
        main(words.split())
    except SystemExit as end:
        assert end.code in (0, 2), (words, end.code)
    loaded = [name for name in {HEAVY} if name in sys.modules]
    assert not loaded, (words, loaded)
print("all of them")
"""
COMMANDS = (
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
)


def test_help_lists_and_mistakes_load_neither_torch_nor_what_draws() -> None:
    """One after the other in a process: what one loads is found after that one."""
    command = [sys.executable, "-c", PROGRAM, *COMMANDS]
    result = subprocess.run(command, capture_output=True, text=True)
    assert result.returncode == 0, result.stderr
    assert result.stdout.endswith("all of them\n")
