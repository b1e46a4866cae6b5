"""An exported policy in Python: a policy like any other, but for its step, which is a library."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray
from torch import Tensor

from aicon_torch.control.memory import GOAL_FACTORS, checked_memory, starting_rows
from aicon_torch.errors import ObservationError, OptionError, choices
from aicon_torch.export.exported_memory import ExportedMemory
from aicon_torch.export.layout import Layout
from aicon_torch.export.library import Library
from aicon_torch.export.plain_readings import PlainReadings
from aicon_torch.goals import factor_of
from aicon_torch.quantities import Actuator, Sensor
from aicon_torch.readings.observation import read
from aicon_torch.readings.perception import Perception

Array = NDArray[Any]


def load_exported(path: str | Path, perception: Perception | None = None) -> "ExportedPolicy":
    """Load what :meth:`aicon_torch.Policy.export` wrote.

    The file is native code, which runs with your rights: load none that you would not execute.

    Args:
        path: The file, which ends in ``.so``.
        perception: What makes readings of raw observations, if the policy had a perception: it is
            not in the file.

    Raises:
        OptionError: If the file is damaged, or is not an exported policy for this machine and this
            version, or does not compute what it did when it was exported.

    Example:
        >>> policy = load_exported("pusht.so")
        >>> action, memory = policy.predict(observation)
    """
    return ExportedPolicy(Library.read(path), perception)


class ExportedPolicy:
    """A policy whose control step is a library; :func:`load_exported` loads it.

    It takes any number of robots, ``(*B, size)``. What is batched, checked and returned is as in
    :class:`aicon_torch.Policy`, but for the memory, which is read like a dictionary and is one
    array. It can be copied and pickled, with its library, which is code.

    Args:
        library: The library.
        perception: What makes readings of raw observations.

    Attributes:
        metadata: What the file says of itself: the task, the sensors, the precision, and so on.
    """

    def __init__(self, library: Library, perception: Perception | None) -> None:
        self.metadata, self.perception = library.metadata, perception
        self.goals = tuple(self.metadata["goals"])
        self._library = library
        self._layout = Layout.from_json(self.metadata["memory"])
        self._readings = Layout.from_json(self.metadata["readings"])
        self._commands = Layout.from_json(self.metadata["commands"])
        self._like = torch.from_numpy(np.empty((), dtype=library.dtype))
        self._memory: ExportedMemory | None = None

        self._shapes = {name: entry.shape for name, entry in self._layout.entries.items()}
        self._integers = self._layout.integers

        self._sensors = _sensors_of(self.metadata)
        self._actuators = _actuators_of(self.metadata)
        self._plain = PlainReadings(self._sensors, self._actuators, library.dtype)

    def predict(
        self,
        observation: Mapping[str, Any],
        state: Mapping[str, Tensor] | None = None,
        episode_start: ArrayLike | Tensor | None = None,
        deterministic: bool = True,
    ) -> tuple[Any, ExportedMemory]:
        """One control step: see :meth:`aicon_torch.Policy.predict`.

        Args:
            observation: A reading for each sensor, ``(*B, size)``, numpy or torch.
            state: The memory that the last step returned; None starts an episode.
            episode_start: Rows ``(*B,)`` whose observation is the first of an episode.
            deterministic: Accepted for the signature's sake.

        Returns:
            The action ``(*B, size)``, of the observation's kind (a dict of them if there are
            several actuators), and the memory.

        Raises:
            ObservationError: As for a policy that was not exported.
        """
        if self.perception is not None:
            observation = self._perceive(self.perception, observation, state, episode_start)

        # The usual case, quickly: the next step of one robot, with its readings in arrays.
        readings, before = self._plain.of(observation), self._own(state)
        if (
            readings is not None
            and (before is not None and before.ndim == 1)
            and (episode_start is None or (np.size(episode_start) == 1 and not episode_start))
        ):
            after, commands = self._library.run(readings, before, None)
            return self._action(commands, False), ExportedMemory(after, self._layout)

        readings, before, starts = self._checked(observation, state, episode_start)
        after, commands = self._library.run(readings, before, starts)
        takes_tensors = any(isinstance(reading, Tensor) for reading in observation.values())
        return self._action(commands, takes_tensors), ExportedMemory(after, self._layout)

    def reset(self) -> None:
        """Forget the memory that :meth:`act` keeps."""
        self._memory = None

    def act(self, observation: Mapping[str, Any]) -> Any:
        """One control step of a single episode, with the memory kept here: for those in a hurry."""
        action, self._memory = self.predict(observation, self._memory)
        return action

    def switch(self, memory: Mapping[str, Tensor], **goals: float | Tensor) -> ExportedMemory:
        """The memory with goals switched on or off, or weighted, which outlasts the episode.

        Args:
            memory: The memory to start from.
            **goals: For each goal to change its factor, a number >= 0 or ``(*B,)`` of them.

        Raises:
            OptionError: If there is no such goal, or a factor is none.
        """
        # A copy: the memory that was given stays what it is.
        own = self._own(memory)
        flat = torch.from_numpy(self._flat(memory) if own is None else own.copy())
        start = self._layout.entries[GOAL_FACTORS].start
        factors = flat[..., start : start + len(self.goals)]
        for name, factor in goals.items():
            if name not in self.goals:
                raise OptionError(f"No goal is named {name!r}. Goals: {choices(self.goals)}.")
            value = factor_of(name, factor, factors).detach()  # no gradient leads through a library
            factors[..., self.goals.index(name)] = value
        return ExportedMemory(flat.numpy(), self._layout)

    def flat_readings(self, observation: Mapping[str, Any]) -> Array:
        """The readings as the library takes them, ``(*B, n)``, NaN where there are none.

        First those of all sensors, then the ages of those that have one, then executed actions that
        are reported, in the order of ``metadata["readings"]``.

        Args:
            observation: As for :meth:`predict`.

        Raises:
            ObservationError: As for :meth:`predict`.
        """
        readings = read(observation, self._sensors, self._actuators, self._like)
        if self.perception is None:
            self._check_perceived(observation)

        return np.ascontiguousarray(self._readings.pack(readings, self._like).numpy())

    def _checked(
        self,
        observation: Mapping[str, Any],
        state: Mapping[str, Tensor] | None,
        episode_start: ArrayLike | Tensor | None,
    ) -> tuple[Array, Array, NDArray[np.uint8] | None]:
        """Readings, memory and the rows that start anew, for any batch."""
        flat = self.flat_readings(observation)
        batch = flat.shape[:-1]

        # An episode of all rows begins.
        if state is None:
            blank = np.broadcast_to(self._library.blank(), (*batch, self._library.memory))
            return flat, np.ascontiguousarray(blank), np.ones(batch, dtype=np.uint8)

        # Some go on, and some begin. What this policy has returned needs no look at every entry.
        before = self._own(state)
        if before is None or before.shape[:-1] != batch:
            before = self._flat(state, batch)
        before = np.ascontiguousarray(before)
        starts = starting_rows(episode_start, batch, torch.device("cpu"))
        if starts is None:
            return flat, before, None
        return flat, before, np.ascontiguousarray(starts.numpy().astype(np.uint8))

    def _check_perceived(self, observation: Mapping[str, Any]) -> None:
        """Readings that a perception makes are there, since there is none here to make them."""
        for name in self.metadata["perceived"]:
            key = self._sensors[name].key_of(name)
            if key not in observation:
                raise ObservationError(
                    f"Sensor {name!r}: the observation has no {key!r}, and the perception that may "
                    "make it is not in the file; give it: load_exported(path, perception=...)."
                )

    def _perceive(
        self,
        perception: Perception,
        observation: Mapping[str, Any],
        state: Mapping[str, Tensor] | None,
        episode_start: ArrayLike | Tensor | None,
    ) -> Mapping[str, Any]:
        """The observation with what the perception makes of it."""
        if state is None:
            return perception(observation, None, None)

        if self._own(state) is None:
            state = checked_memory(state, self._shapes, self._integers, self._like)

        # Every memory has the factors of the goals, so they tell how many robots there are.
        batch = tuple(state[GOAL_FACTORS].shape[:-1])
        starts = starting_rows(episode_start, batch, torch.device("cpu"))
        return perception(observation, state, None if starts is None else starts.numpy())

    def _flat(self, memory: Mapping[str, Tensor], batch: tuple[int, ...] | None = None) -> Array:
        """The numbers of a memory, which may be that of another policy of this graph."""
        checked = checked_memory(memory, self._shapes, self._integers, self._like, batch)
        return ExportedMemory.of(checked, self._layout, self._library.dtype).flat

    def _own(self, memory: Mapping[str, Tensor] | None) -> Array | None:
        """The numbers of a memory that this policy has returned; None for any other."""
        if isinstance(memory, ExportedMemory) and memory.layout is self._layout:
            return memory.flat
        return None

    def _action(self, commands: Array, takes_tensors: bool) -> Any:
        """The commands of the observation's kind, and alone where there is one actuator."""
        if len(self._commands.entries) == 1:
            return torch.from_numpy(commands) if takes_tensors else commands.astype(np.float32)

        actions: dict[str, Any] = {}
        for name, command in self._commands.unpack(torch.from_numpy(commands)).items():
            actions[name] = command if takes_tensors else command.numpy().astype(np.float32)
        return actions


def _sensors_of(metadata: Mapping[str, Any]) -> dict[str, Sensor]:
    """The sensors that a file describes, without what the library does itself, such as units."""
    sensors: dict[str, Sensor] = {}
    for described in metadata["sensors"]:
        fields = {key: described[key] for key in ("key", "optional", "age", "age_key")}
        sensors[described["name"]] = Sensor(described["size"], described["unit"], **fields)
    return sensors


def _actuators_of(metadata: Mapping[str, Any]) -> dict[str, Actuator]:
    """The actuators that a file describes."""
    actuators: dict[str, Actuator] = {}
    for described in metadata["actuators"]:
        actuator = Actuator(described["size"], described["unit"], key=described["key"])
        actuators[described["name"]] = actuator
    return actuators
