"""What a model's watchdog asks of readings that may come late."""

from typing import Any, Protocol


class WatchedOptions(Protocol):
    """The options that tell how late readings are."""

    @property
    def dt(self) -> float:
        """Time step, s."""

    @property
    def delay(self) -> int:
        """How late readings are, steps."""

    @property
    def watchdog(self) -> bool:
        """Whether missing readings are watched."""


def watched(options: WatchedOptions, most: float) -> dict[str, Any]:
    """Arguments of a sensor: how old its readings are, and how old they may be.

    Args:
        options: The options of the model.
        most: Steps without a reading after which actions decay.
    """
    latency = options.delay * options.dt
    ages: dict[str, Any] = {"age": latency, "age_key": "age"}
    if options.watchdog:
        gap = most * options.dt
        ages |= {"max_age": latency + gap, "max_gap": gap}
    return ages
