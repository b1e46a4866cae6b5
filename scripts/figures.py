"""The command `aicon figures` as a script, for a checkout that is not installed.

Example: python scripts/figures.py nav2d --out runs/figures
"""

import sys

from aicon_baselines.cli.main import main

if __name__ == "__main__":
    main(["figures", *sys.argv[1:]])
