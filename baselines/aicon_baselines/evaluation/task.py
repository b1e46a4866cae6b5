"""What an evaluation task is: how a seed becomes an episode, and how episodes become a batch."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from gymnasium.vector import VectorEnv
from numpy.typing import NDArray

if TYPE_CHECKING:
    from aicon_baselines.named import Later


@dataclass(frozen=True)
class Episode:
    """One episode, the same for every policy.

    Attributes:
        seed: Chooses the class of map and the map itself.
        repeat: Tells apart the noise of several runs on the same map.
        map: Name of the class of map.
    """

    seed: int
    repeat: int
    map: str

    @property
    def noise_seed(self) -> int:
        """Seed of the environment's noise, one per (seed, repeat)."""
        sequence = np.random.SeedSequence([self.seed, self.repeat])
        return int(sequence.generate_state(1)[0])


def by_seed(episodes: Sequence[Episode]) -> dict[str, Any]:
    """Each episode begins as its seed says."""
    return {"seed": [episode.seed for episode in episodes]}


def told_nothing(condition: str) -> dict[str, Any]:
    """No options: a policy is told the same in every condition."""
    return {}


@dataclass(frozen=True)
class Measure:
    """What else an environment of a task says of an episode.

    Attributes:
        key: Its name in `info` and in the rows.
        title: Heading of its column.
        form: How it is written, such as "{:.1f} mm".
        scale: Factor from the unit of `info` to that of the form.
        least: Whether the least value of the episode counts, and the least of all episodes;
            otherwise the last value, and the median of the successes.
    """

    key: str
    title: str
    form: str
    scale: float = 1.0
    least: bool = False


@dataclass(frozen=True)
class Look:
    """How a task is shown. What is named, as "module:name", is imported when it is needed.

    Attributes:
        scene: Makes its scene in the live view, from a server and an episode: a subclass of
            :class:`aicon_baselines.view.Scene`.
        surroundings: Says what lies around the robot in the picture of a diagnosis, from the
            environment of one episode and its last info.
        condition: The condition that is watched where none is named; by default the usual one.
        options: Of the environment and of the policy, where more is to be seen than usually.
    """

    scene: str = ""
    surroundings: str = ""
    condition: str = ""
    options: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Lesson:
    """What a student of a task sees and does, by the names that LeRobot has for it.

    Attributes:
        words: What it is to do.
        seen: For each feature the readings that are joined in it.
        done: For each part of the action how many numbers it is; an action of one part is plain.
    """

    words: str
    seen: Mapping[str, tuple[str, ...]]
    done: Mapping[str, int]

    def feature(self, name: str, observation: Mapping[str, NDArray[Any]]) -> NDArray[Any]:
        """A feature (B, ...) of a batch of observations."""
        return np.concatenate([observation[reading] for reading in self.seen[name]], axis=-1)

    def joined(self, action: Any) -> NDArray[np.float32]:
        """The parts of a batch of actions as one array (B, n)."""
        if len(self.done) > 1:
            action = np.concatenate([action[part] for part in self.done], axis=-1)
        return np.asarray(action, np.float32)

    def parted(self, actions: NDArray[np.float32]) -> Any:
        """The action that is one array (B, n), as the environment takes it."""
        if len(self.done) == 1:
            return actions
        ends = np.cumsum(list(self.done.values()))[:-1]
        return dict(zip(self.done, np.split(actions, ends, axis=-1), strict=True))


@dataclass(frozen=True)
class Task:
    """An evaluation task: all that the commands know of it.

    It is registered by its name in :mod:`aicon_baselines.tasks`, by an entry point of the group
    ``aicon.tasks``, or named MODULE:TASK; :func:`aicon_baselines.tasks.check_task` says what a new
    one lacks. Its module loads no torch, so that `aicon list` is quick: what does is named, as
    "module:name", and imported when it is needed.

    Attributes:
        name: Name of the task, by which it is loaded again.
        time_step: Duration of one control step, s.
        horizon: Steps after which an episode ends at the latest. It has succeeded if `is_success`
            says so in its last step; an environment that terminates on arrival ends it there.
        chunk_size: Number of episodes stepped as one batch; a constant, see `chunk`.
        maps: Slots of map classes; seed s plays `maps[s % len(maps)]`.
        conditions: Names of the variants of the environment, the usual one first.
        make_env: Builds the environment from (number of episodes, condition, horizon in steps), and
            from further arguments of the environment, such as the `env_options` of a policy that
            has some or `render_mode`. It must leave ended episodes alone (autoreset disabled;
            `StandStillAfterEnd` and `SideBySide` make one of single environments) and report
            `position` (B, 2), `distance` (B,), both in `length_unit`, `is_success` (B,),
            `collision` (B,) and what `measures` names in `info`.
        reset_arguments: The arguments of the environment's `reset` that select these episodes; by
            default their seeds.
        policy_options: What a policy is told about a condition: options of its model; by default
            nothing.
        faults: Those of them that may happen at once: ``"late+bias"`` is a condition as well.
        noiseless: Conditions without noise, where the repeats of an episode would be copies of it.
        length_unit: Unit of the lengths in the rows.
        time_unit: Unit in which durations are told.
        milestones: Numbers of steps within which success is reported as well; curves mark the last.
        measures: What else the rows hold; the environment must report it in `info`.
        patterns: The conditions as patterns of a shell, such as "{a,b}_{c,d}", where they are many.
        shortest_path_length: Length of the shortest collision-free path of an episode, in
            `length_unit`; None where a path has no such bound and nothing to collide with.
        model: Name of the library's model of the task, or the name of a module like one: with
            `Options`, `PRESETS` and `build`. Empty where there is none.
        presets: The presets of the model that are compared, ours first.
        ablations: Ours without a part: for each name the options that differ.
        agents: Policies of others, each named: a dataclass with `predict`, whose fields are its
            options and which needs none of them; as :class:`~aicon_baselines.named.Later` with some
            of them.
        timed_condition: The condition that `aicon bench` times; by default the usual one.
        look: How it is shown.
        lesson: What a student sees and does that learns it from demonstrations; None where there is
            none.
    """

    name: str
    time_step: float
    horizon: int
    chunk_size: int
    maps: tuple[str, ...]
    conditions: tuple[str, ...]
    make_env: Callable[..., VectorEnv[Any, Any, Any]]
    reset_arguments: Callable[[Sequence[Episode]], dict[str, Any]] = by_seed
    policy_options: Callable[[str], dict[str, Any]] = told_nothing
    faults: tuple[str, ...] = ()
    noiseless: tuple[str, ...] = ()
    length_unit: Literal["m", "px"] = "m"
    time_unit: Literal["s", "steps"] = "s"
    milestones: tuple[int, ...] = ()
    measures: tuple[Measure, ...] = ()
    patterns: tuple[str, ...] = ()
    shortest_path_length: Callable[[Episode], float] | None = None
    model: str = ""
    presets: tuple[str, ...] = ()
    ablations: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    agents: Mapping[str, "str | Later"] = field(default_factory=dict)
    timed_condition: str = ""
    look: Look = Look()
    lesson: Lesson | None = None

    @property
    def time_scale(self) -> float:
        """Duration of one control step in `time_unit`."""
        return self.time_step if self.time_unit == "s" else 1.0

    def duration(self, steps: int) -> str:
        """Tell a number of steps in `time_unit`."""
        return f"{steps * self.time_scale:g} {self.time_unit}"

    def has_condition(self, name: str) -> bool:
        """Whether it is one of the conditions, or several different faults joined by a plus."""
        parts = name.split("+")
        are_faults = len(parts) == len(set(parts)) and set(parts) <= set(self.faults)
        return name in self.conditions or are_faults

    def is_noiseless(self, name: str) -> bool:
        """Whether repeats would be copies: in each of the faults at once, where they are joined."""
        return name in self.noiseless or set(name.split("+")) <= set(self.noiseless)

    def episode(self, seed: int, repeat: int = 0) -> Episode:
        """Return the episode of a seed."""
        return Episode(seed, repeat, self.maps[seed % len(self.maps)])

    def chunk(self, index: int, repeat: int) -> list[Episode]:
        """List the episodes of seeds [index * chunk_size, (index + 1) * chunk_size).

        They are stepped together. The last bits of a batched computation depend on the size of the
        batch, and closed loops among obstacles amplify them. So a chunk is always complete and
        starts at a multiple of its size, also when only some of its seeds were asked for: an
        episode has the same neighbours, hence the same row, in every run.
        """
        first = index * self.chunk_size
        return [self.episode(seed, repeat) for seed in range(first, first + self.chunk_size)]
