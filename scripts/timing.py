"""Programs timed side by side: they take turns, and what counts is the processor time of this process."""

import statistics
import time
from collections.abc import Callable, Mapping

from tqdm import tqdm

Step = Callable[[], None]


def take_turns(programs: Mapping[str, Step], rounds: int, steps: int, name: str) -> dict[str, list[float]]:
    """Mean processor seconds per step in each round, for each program."""
    for step in programs.values():
        for _ in range(steps):
            step()
    times: dict[str, list[float]] = {program: [] for program in programs}
    for _ in tqdm(range(rounds), desc=name, disable=None):
        for program, step in programs.items():
            start = time.process_time()
            for _ in range(steps):
                step()
            times[program].append((time.process_time() - start) / steps)
    return times


def spread(values: list[float], factor: float = 1.0) -> str:
    """Median (5 % to 95 %) of the values times a factor."""
    cuts = statistics.quantiles([value * factor for value in values], n=20, method="inclusive")
    return f"{statistics.median(values) * factor:.3g} ({cuts[0]:.3g} to {cuts[-1]:.3g})"
