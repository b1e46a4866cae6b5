"""Numbers in words."""

from collections.abc import Sequence

from aicon_baselines.diagnosis.history import History


def seconds(time: float) -> str:
    """``"3.4 s"``, ``"250 s"``."""
    return f"{time:.1f} s" if time < 100 else f"{time:.0f} s"


def times(count: int) -> str:
    """``"once"``, ``"twice"``, ``"3 times"``."""
    return {1: "once", 2: "twice"}.get(count, f"{count} times")


def percent(share: float) -> str:
    """``"64 %"``."""
    return f"{share:.0%}".replace("%", " %")


def listed(names: Sequence[str]) -> str:
    """``"a, b and c"``."""
    if len(names) < 2:
        return "".join(names)
    return f"{', '.join(names[:-1])} and {names[-1]}"


def costs_in_words(history: History) -> str:
    """What is left of the goals that are followed, at the end."""
    left: list[str] = []
    for name, curve in history.goals.items():
        if not curve.safety:
            first, best, last = curve.cost[0], curve.cost.min(), curve.cost[-1]
            left.append(f"{name} {last:.3g} (at the start {first:.3g}, at best {best:.3g})")
    return f"Cost at the end: {', '.join(left)}." if left else "There is no goal."
