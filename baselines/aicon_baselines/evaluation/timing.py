"""Programs timed side by side: they take turns, and processor time of this process is what counts.

So a busy machine slows all of them alike, and their ratios hold.
"""

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import cycle
from typing import Any

import numpy as np

from aicon_baselines.evaluation.errors import check_counts
from aicon_baselines.evaluation.predictor import Predictor
from aicon_baselines.extras import naming_extra

with naming_extra():
    from tqdm import tqdm

Step = Callable[[], None]
"""One step of a program."""


def take_turns(
    programs: Mapping[str, Step], rounds: int, steps: int, name: str
) -> dict[str, list[float]]:
    """Return the mean processor seconds per step of each program in each round.

    Args:
        programs: What is timed, by name.
        rounds: How often every program has its turn.
        steps: Number of steps in a turn.
        name: What the progress bar says.

    Raises:
        ComparisonError: If there is no round, or no step in one.
    """
    check_counts(rounds=rounds, steps=steps)

    # The first steps are slower: they fill caches, and compile where a program does that.
    for step in programs.values():
        _repeat(step, steps)

    times: dict[str, list[float]] = {program: [] for program in programs}
    for _ in tqdm(range(rounds), desc=name, disable=None):
        for program, step in programs.items():
            start = time.process_time()
            _repeat(step, steps)
            times[program].append((time.process_time() - start) / steps)
    return times


def ratios(numerators: Iterable[float], denominators: Iterable[float]) -> list[float]:
    """Divide round by round, so that what slowed both in a round cancels."""
    return [first / second for first, second in zip(numerators, denominators, strict=True)]


def spread(values: Iterable[float], factor: float = 1.0) -> str:
    """Write median (5 % to 95 %) of the values times a factor."""
    percentiles = factor * np.percentile(np.fromiter(values, np.float64), (5, 50, 95))
    low, middle, high = (_three_digits(value) for value in percentiles.tolist())
    return f"{middle} ({low} to {high})"


def _three_digits(value: float) -> str:
    """A number with three digits or more, never as a power of ten."""
    return f"{value:.3g}" if abs(value) < 999.5 else f"{value:,.0f}"


def replay(policy: Predictor, observations: Sequence[Any]) -> Step:
    """Return one step of a policy on the next of these observations, again and again."""
    upcoming, memory = cycle(observations), None

    def step() -> None:
        nonlocal memory
        _, memory = policy.predict(next(upcoming), memory)

    return step


def _repeat(step: Step, count: int) -> None:
    for _ in range(count):
        step()


def processor_seconds() -> float:
    """Seconds of the processor that this process took, and those that it started and that ended."""
    import resource  # not on Windows

    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(each.ru_utime + each.ru_stime for each in used)
