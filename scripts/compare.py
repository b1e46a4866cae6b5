"""The command `aicon compare` as a script, for a checkout that is not installed.

Example: python scripts/compare.py --task nav2d --policies aicon steepest --out runs/nav2d
"""

import sys

from aicon_baselines.cli.main import main

if __name__ == "__main__":
    main(["compare", *sys.argv[1:]])
