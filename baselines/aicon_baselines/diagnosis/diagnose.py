"""The diagnosis: what the robot did in the end, and what may be why."""

from dataclasses import dataclass

from aicon_baselines.diagnosis.behaviour import find_behaviour
from aicon_baselines.diagnosis.conflicts import find_conflicts, find_constraints
from aicon_baselines.diagnosis.finding import Finding
from aicon_baselines.diagnosis.history import History
from aicon_baselines.diagnosis.limits import (
    find_coarseness,
    find_limits,
    find_restlessness,
    find_slowness,
)
from aicon_baselines.diagnosis.readings import find_disagreements, find_silence
from aicon_baselines.evaluation.recording import Recording


@dataclass(frozen=True)
class Diagnosis:
    """What is seen in an episode; `print` says it in words.

    Attributes:
        behaviour: What the robot did in the end.
        causes: What may be why, from what stands between the robot and the world to what stands
            between its goals. Each is something that was seen, and none is proven to be the cause.
        success: Whether the episode succeeded; None where nobody knows.
    """

    behaviour: Finding
    causes: tuple[Finding, ...]
    success: bool | None = None

    def __str__(self) -> str:
        """The behaviour, and a line for each cause."""
        if self.success:
            return "The episode succeeded: there is nothing to explain."
        lines = [self.behaviour.text]
        lines += [f"- {cause.text}" for cause in self.causes]
        if not self.causes:
            lines.append("- Nothing else stands out.")
        return "\n".join(lines)


def diagnose(episode: Recording | History) -> Diagnosis:
    """Say what is seen in an episode.

    Causes are looked for in the time of the behaviour: of a cycle since it began, and so on; of a
    robot that wandered or was on its way, in the second half.

    Args:
        episode: The episode of a single robot, of two steps or more.
    """
    history = History.of(episode) if isinstance(episode, Recording) else episode
    behaviour = find_behaviour(history)
    lasts = behaviour.kind in ("standstill", "cycle")
    since = round(behaviour.begin / history.dt) if lasts else history.steps // 2
    since = min(since, history.steps - 2)

    causes = (
        *find_silence(history, since),
        *find_disagreements(history, since),
        *find_conflicts(history, since),
        *find_constraints(history, since),
        *find_slowness(history, since),
        *find_coarseness(history, since),
        *find_limits(history, since),
        *find_restlessness(history, since),
    )
    return Diagnosis(behaviour, causes, history.success)
