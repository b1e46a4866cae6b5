"""Say why an episode of a comparison failed, in words and in one picture.

Example: aicon diagnose runs/first --seed 3

RUN is a folder that aicon compare wrote. The episode is run again, alone and compiled, with the
policy, condition and horizon of the run, and its trace is looked at: did the robot stand still, go
in circles, or run out of time? Which gradients stood against each other, which goal never rested,
which actuator was at its limit, which readings contradicted the estimates? Last comes what led,
turn by turn: the path from a goal to each actuator, and what stood against what.

What it says was seen; that it is the cause, an experiment shows: aicon watch is one to begin with.
"""

import argparse
from pathlib import Path

from aicon_baselines.cli.command_line import Command


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the run, the episode and the picture."""
    parser.add_argument("run", type=Path, metavar="RUN", help="folder that aicon compare wrote")
    parser.add_argument("--seed", type=int, required=True, help="seed of the episode")
    parser.add_argument(
        "--policy", metavar="NAME", help="as the rows call it (default: that failed)"
    )
    parser.add_argument("--condition", metavar="NAME", help="condition (default: that failed)")
    parser.add_argument(
        "--picture", type=Path, metavar="FILE", help="default: RUN/diagnosis_SEED.png"
    )


def run(arguments: argparse.Namespace) -> None:
    """Run the episode again, and say what is seen in it."""
    from aicon_baselines.diagnosis import diagnose
    from aicon_baselines.diagnosis.picture import draw_diagnosis
    from aicon_baselines.diagnosis.rerun import rerun
    from aicon_baselines.diagnosis.turns import find_turns

    again = rerun(arguments.run, arguments.seed, arguments.policy, arguments.condition)
    found = diagnose(again.history)

    path = arguments.picture or arguments.run / f"diagnosis_{arguments.seed}.png"
    draw_diagnosis(
        again.history,
        found,
        path,
        title=str(again),
        places=again.places,
        around=again.around,
        flipped=again.flipped,
    )

    print(again)
    if again.row.success != again.recording.success:
        print(
            "In the comparison it was otherwise. There the episode was one of a batch: in the last "
            "bits it differs, and that decided."
        )
    print(f"\n{found}\n\nWhat led, turn by turn:")
    for turn in find_turns(again.history):
        print(turn)
    print(f"\nsaved: {path}")


COMMAND = Command(__doc__, add_arguments, run)
