"""The command `aicon`.

aicon list                      tasks, policies, conditions, environments, extras
aicon run --task nav2d          one episode, and what the policy decided at its end
aicon watch pusht               the same live in the browser, with your own hands in it
aicon compare --task pusht ...  policies on the same episodes: rows, table, curves
aicon diagnose RUN --seed 3     why an episode of a comparison failed
aicon figures nav2d             the figure and the film of a rollout
aicon bench                     the time of a control step, compiled and not
aicon export pusht -o pusht.so  a policy as a file that runs without torch
"""

from collections.abc import Sequence
from importlib import import_module
from importlib.metadata import version
from sys import argv

from aicon_baselines.cli.command_line import (
    Command,
    errors_as_sentences,
    make_parser,
    run_command,
)

# A module is imported when its command is named: what it needs may come with an extra.
_MODULES = {
    "list": "aicon_baselines.cli.listing",
    "run": "aicon_baselines.cli.run",
    "watch": "aicon_baselines.cli.watch",
    "compare": "aicon_baselines.cli.compare",
    "diagnose": "aicon_baselines.cli.diagnose",
    "figures": "aicon_baselines.cli.figures",
    "bench": "aicon_baselines.cli.bench",
    "export": "aicon_baselines.cli.export",
}


def main(arguments: Sequence[str] | None = None) -> None:
    """Run one of the commands; `aicon COMMAND --help` tells its arguments."""
    words = argv[1:] if arguments is None else list(arguments)

    parser = make_parser(__doc__, "aicon")
    parser.add_argument("--version", action="version", version=version("aicon-torch"))
    parser.add_argument("command", choices=_MODULES, help="aicon COMMAND --help tells more")
    name = parser.parse_args(words[:1]).command

    with errors_as_sentences(parser):
        command: Command = import_module(_MODULES[name]).COMMAND
    run_command(command, words[1:], f"aicon {name}")


if __name__ == "__main__":
    main()
