"""What the watchdog asks of readings that may be late."""

from typing import Any


def watched(dt: float, delay: int, gap: float | None) -> dict[str, Any]:
    """How old readings are, and may be: for :class:`aicon_torch.Sensor`.

    Args:
        dt: Time step, s.
        delay: The age that is made up for, steps.
        gap: For how many steps none need come; None where nothing is watched.
    """
    latency = delay * dt
    told: dict[str, Any] = {"age": latency, "age_key": "age"}
    if gap is not None:
        told |= {"max_age": latency + gap * dt, "max_gap": gap * dt}
    return told


def prompt(dt: float, gap: float | None) -> dict[str, Any]:
    """The same of readings that are never late, without a key for their age."""
    return {} if gap is None else {"max_age": gap * dt}
