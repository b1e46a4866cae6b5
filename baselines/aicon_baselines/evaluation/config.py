"""What a run folder was made for, so that rows of different episodes never share a file."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from aicon_baselines.evaluation.errors import ComparisonError, check_counts, check_known
from aicon_baselines.evaluation.task import Task
from aicon_baselines.files import check_same_config, read_json, write_json


@dataclass(frozen=True)
class Config:
    """The episodes of a comparison; policies, jobs and backend are free: no row depends on them.

    Attributes:
        task: Name of the task.
        seed: First seed.
        episodes: Number of seeds, per condition and repeat.
        repeats: Number of runs of each seed, with different noise.
        conditions: Variants of the environment.
        maps: Slots of map classes; seed s plays `maps[s % len(maps)]`.
        horizon: Steps after which an episode ends at the latest.
        time_step: Duration of one step, s.
    """

    task: str
    seed: int
    episodes: int
    repeats: int
    conditions: tuple[str, ...]
    maps: tuple[str, ...]
    horizon: int
    time_step: float

    def __post_init__(self) -> None:
        """Reject what cannot be run."""
        if self.seed < 0:
            raise ComparisonError(f"the first seed must be 0 or more, not {self.seed}")

        check_counts(episodes=self.episodes, repeats=self.repeats, horizon=self.horizon)

    @property
    def seeds(self) -> range:
        """The seeds of the comparison."""
        return range(self.seed, self.seed + self.episodes)

    def apply(self, task: Task) -> Task:
        """Return the task with this comparison's maps and horizon, and the milestones within it."""
        milestones = tuple(steps for steps in task.milestones if steps <= self.horizon)
        return replace(task, maps=self.maps, horizon=self.horizon, milestones=milestones)

    @classmethod
    def load(cls, path: Path) -> "Config":
        """Read a saved configuration.

        Raises:
            ComparisonError: If there is none, or it is one of another version.
        """
        if not path.exists():
            raise ComparisonError(f"{path.parent} is no folder of a comparison: no {path.name}")
        saved: dict[str, Any] = {}
        for name, value in _read(path).items():
            saved[name] = tuple(value) if isinstance(value, list) else value
        try:
            return cls(**saved)
        except TypeError as error:
            raise ComparisonError(f"{path} is of another version: {error}") from error

    def save(self, path: Path) -> None:
        """Write the configuration as JSON, or check that the file there holds the same one.

        Raises:
            ComparisonError: If it holds another one or none, or cannot be read or written.
        """
        if not path.exists():
            write_json(path, asdict(self))
            return

        saved = _read(path)
        wanted = {**dict.fromkeys(saved), **asdict(self)}
        check_same_config(path.parent, "another comparison", saved, wanted)


def _read(path: Path) -> dict[str, Any]:
    """Read a saved configuration."""
    try:
        return read_json(path)
    except ComparisonError as error:
        raise ComparisonError(
            f"{error}. It should say what the folder was made for: choose another folder or, if "
            "its rows are of this very comparison, delete that file"
        ) from error


def configure(
    task: Task,
    seed: int = 0,
    episodes: int = 100,
    repeats: int = 1,
    conditions: Sequence[str] | None = None,
    maps: Sequence[str] | None = None,
    horizon: int | None = None,
) -> Config:
    """Describe a comparison on a task; the arguments are the attributes of `Config`.

    By default it is the task's first condition, its slots of maps and its horizon. An unknown
    condition or map is an error that lists the valid ones.
    """
    # The repeats of an episode differ in their noise only.
    conditions = _check_conditions(conditions or task.conditions[:1], task)
    noiseless = [name for name in conditions if task.is_noiseless(name)]
    if repeats > 1 and noiseless:
        raise ComparisonError(
            f"repeats must be 1, not {repeats}, without noise, as in {', '.join(noiseless)}"
        )
    for name in maps or ():
        check_known("map", name, task.maps)

    return Config(
        task=task.name,
        seed=seed,
        episodes=episodes,
        repeats=repeats,
        conditions=conditions,
        maps=tuple(dict.fromkeys(maps)) if maps else task.maps,
        horizon=task.horizon if horizon is None else horizon,
        time_step=task.time_step,
    )


def one_episode(
    task: Task, condition: str | None, seed: int, horizon: int | None = None
) -> tuple[Task, str]:
    """Check a single episode as a comparison would; return its task and its condition."""
    conditions = [condition] if condition else None
    config = configure(task, seed=seed, episodes=1, conditions=conditions, horizon=horizon)
    return config.apply(task), config.conditions[0]


def _check_conditions(names: Sequence[str], task: Task) -> tuple[str, ...]:
    """Return the conditions, each once; faults of the task may be joined by a plus."""
    choices = ", ".join(task.conditions)
    if task.faults:
        example = "+".join(task.faults[:2])
        choices += f"; or several at once of {', '.join(task.faults)}, such as {example}"

    for name in names:
        if not task.has_condition(name):
            raise ComparisonError(f"unknown condition {name!r}; valid conditions: {choices}")
    return tuple(dict.fromkeys(names))
