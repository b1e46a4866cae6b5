"""The extended Kalman filter for readings that come late."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import torch
from torch import Tensor, nn

from aicon_torch.errors import GraphError, choices, in_order
from aicon_torch.estimation.ekf import EKF
from aicon_torch.estimation.measurement import Innovation, Measurement, in_turn
from aicon_torch.interconnections import Values
from aicon_torch.quantities import AGE, PRESENT, as_count, as_size


class LateEKF(EKF):
    """An :class:`EKF` whose readings are late, by any and varying amounts of up to L steps.

    A reading corrects the belief of when it was taken, which is then moved on to now by what moved
    the quantity since: filter, then predict (Larsen et al. 1998). Beside mean and covariance it
    owns, under their names with a suffix, the belief at the last reading (``_then``), how many
    steps ago that was (``_lag``), and what moved it in the last L + 1 steps (``_moves``). Times
    count to the nearest beginning of a step. With L = 0 it is an :class:`EKF`.

    Args:
        mean: As for :class:`EKF`.
        covariance: As for :class:`EKF`.
        sensor: The sensor whose age tells when the readings were taken, or several that come one at
            a time.
        steps: L, the largest age of a reading that is made up for; an older one counts as so old.
        moved_by: What ``predict`` and ``prompt`` read besides the mean, with the number of its
            components; with ``"dt": 1`` each step counts as long as the clock says. Of a sensor
            that ``prompt`` reads, ``"name.present": 1`` remembers when it had a reading.
        prompt: Measurements that are on time, such as of a force that is felt. Each corrects the
            belief of its own step, and again whenever that step is gone through.
        **options: As for :class:`EKF`.

    Example:
        >>> LateEKF("p_tar", "P_tar", sensor="z_tar", steps=8, moved_by={"x_rob": 2},
        ...     predict=approach, noise=1e-6, initial=((5.0, 0.0), 9.0), correct=[bearing])
    """

    def __init__(
        self,
        mean: str,
        covariance: str,
        *,
        sensor: str | Sequence[str],
        steps: int,
        moved_by: Mapping[str, int],
        prompt: Sequence[Measurement] = (),
        **options: Any,
    ) -> None:
        super().__init__(mean, covariance, **options)
        several = (sensor,) if isinstance(sensor, str) else sensor
        self.sensors = in_order(f"sensor of {mean!r}", several)
        self.steps = as_count(steps)
        if self.steps < 0:
            raise GraphError(f"steps={steps!r} of {mean!r}: expected a number of steps >= 0.")
        what = f"moved_by of {mean!r}:"
        if not isinstance(moved_by, Mapping):
            raise GraphError(f"{what} expected sizes by name, such as {{'x_rob': 2}}.")
        self.moved_by = {name: as_size(f"{what} {name!r}", n) for name, n in moved_by.items()}
        self._prompt = in_turn(f"prompt of {mean!r}", prompt)
        self.prompt = nn.ModuleList(self._prompt)  # registers them

        # What is to be remembered of a step.
        felt: list[str] = []
        for measurement in self._prompt:
            self._must_read_mean(f"A prompt measurement of {mean!r}", measurement.residual)
            felt.extend(measurement.inputs)
        self.felt = tuple(dict.fromkeys(felt))
        read = [*self.predict.inputs, *self.felt]
        flags = [name + PRESENT for name in self.felt]
        for name in self.moved_by:
            if name not in (*read, *flags, "dt"):
                raise GraphError(
                    f"moved_by of {mean!r}: predict and prompt read "
                    f"{choices(dict.fromkeys(read))}, not {name!r}."
                )

        self.then = (f"{mean}_then", f"{covariance}_then")
        self.lag, self.moves = f"{mean}_lag", f"{mean}_moves"
        self.outputs = (mean, covariance, *self.then, self.lag, self.moves)
        self.covariances = (covariance, self.then[1])
        inputs = (*self.inputs, *read, *self.sensors, *self.then, self.lag, self.moves)
        self.inputs = tuple(dict.fromkeys(inputs))

    def initial(self, values: Values) -> dict[str, Tensor]:
        """The prior belief, of now; nothing has moved."""
        belief = super().initial(values)
        mean, covariance = belief[self.mean], belief[self.covariance]

        # L + 1 steps, in each of which nothing moved.
        in_step = [self._at_rest(name, values, mean) for name in self.moved_by]
        at_rest = torch.cat(in_step * (self.steps + 1))
        past = {self.then[0]: mean, self.then[1]: covariance}
        return {**belief, **past, self.lag: mean.new_zeros(1), self.moves: at_rest}

    def filtered(self, values: Values) -> tuple[dict[str, Tensor], list[Innovation]]:
        """Move the belief to when the reading was taken, correct it, and move it on to now."""
        moves = self._remembered_moves(values)
        new_lag = self._new_lag(values, moves)

        # To when the reading was taken, ...
        mean, covariance = self._at_reading(values, moves, new_lag)
        mean, covariance, innovations = self._corrections(values, mean, covariance)
        then = {self.then[0]: mean, self.then[1]: covariance}

        # ... and on to now.
        # A reading is at most L steps old, so the oldest of the L + 1 is not gone through again.
        for back, step in list(self._steps(moves))[1:]:
            is_due = back <= new_lag
            mean, covariance = self._moved(values, step, mean, covariance, is_due)
        now = {self.mean: mean, self.covariance: covariance}
        return {**now, **then, self.lag: new_lag, self.moves: moves}, innovations

    def forward(self, values: Values, output: str) -> Tensor:
        """The belief one step ahead, as if readings were on time; what is past stays.

        What ``prompt`` will measure counts as noise.
        """
        if output in (self.mean, self.covariance):
            return super().forward(values, output)
        return values[output]

    def check(self, values: Values) -> None:
        """Check the measurements that are on time as well: see :meth:`EKF.check`."""
        super().check(values)
        for measurement in self._prompt:
            measurement.residual.verify(values, measurement.size)

    def check_sizes(self, values: Values) -> None:
        """Check the measurements that are on time as well: see :meth:`EKF.check_sizes`."""
        super().check_sizes(values)
        self._check_residuals("prompt", self._prompt, values)

    def _at_reading(self, values: Values, moves: Tensor, new_lag: Tensor) -> tuple[Tensor, Tensor]:
        """The belief of when the last reading was taken, moved from that of the one before it.

        Args:
            values: As for :meth:`update`.
            moves: What moved it, as :meth:`_remembered_moves`.
            new_lag: How many steps ago that was, ``(*B, 1)``.
        """
        # The last reading is one step older by now. Each row has as many steps to go as lie between
        # it and the new one.
        lag = values[self.lag] + 1
        mean, covariance = values[self.then[0]], values[self.then[1]]
        for back, step in self._steps(moves):
            is_due = (back <= lag) & (back > new_lag)
            mean, covariance = self._moved(values, step, mean, covariance, is_due)
        return mean, covariance

    def _new_lag(self, values: Values, moves: Tensor) -> Tensor:
        """How many steps ago the last reading was taken, ``(*B, 1)``."""
        # The last reading has aged by a step; the new one's age is counted in steps.
        lag_of_last = values[self.lag] + 1
        age, is_present = self._newest(values)
        lag_of_new = self._steps_within(age, values, moves)

        # One that is older than the last counts as taken with it.
        new_lag = torch.where(is_present, lag_of_new, lag_of_last.clamp(max=self.steps))
        return torch.minimum(new_lag, lag_of_last)

    def _newest(self, values: Values) -> tuple[Tensor, Tensor]:
        """How old the reading is that came, s, and whether one did, ``(*B, 1)`` both."""
        first, *others = self.sensors
        age, is_present = values[first + AGE], values[first + PRESENT]
        for other in others:  # no two at a time
            is_of_other = values[other + PRESENT]
            age = torch.where(is_of_other, values[other + AGE], age)
            is_present = is_present | is_of_other
        return age.unsqueeze(-1), is_present.unsqueeze(-1)

    def _steps_within(self, age: Tensor, values: Values, moves: Tensor) -> Tensor:
        """How many steps an age ``(*B, 1)``, s, is, to the nearest beginning of one."""
        # Back from the latest step: an age includes a step as soon as it reaches beyond its middle.
        count, until = torch.zeros_like(age), torch.zeros_like(age)
        for _, step in reversed(list(self._steps(moves))[1:]):
            duration = step.get("dt", values["dt"])
            count = count + (age > until + duration / 2)
            until = until + duration
        return count

    def _remembered_moves(self, values: Values) -> Tensor:
        """What moved it in the last L + 1 steps, oldest first, ``(*B, (L + 1) m)``."""
        kept = values[self.moves]

        # The oldest step goes, and the latest comes last.
        parts: list[Tensor] = []
        for name in self.moved_by:
            is_flag = name.endswith(PRESENT)
            value = values[name].to(kept.dtype).unsqueeze(-1) if is_flag else values[name]
            parts.append(_per_row(value, kept))
        last = torch.cat(parts, dim=-1)
        kept = kept[..., last.shape[-1] :]
        return torch.cat((kept, last), dim=-1)

    def _at_rest(self, name: str, values: Values, like: Tensor) -> Tensor:
        """What did not move it in a step before the first, ``(size,)``."""
        at_rest = like.new_zeros(self.moved_by[name])
        return at_rest + values["dt"] if name == "dt" else at_rest

    def _steps(self, moves: Tensor) -> Iterator[tuple[int, dict[str, Tensor]]]:
        """For each step how long ago it began, from L + 1 to 1, and what moved it then."""
        by_step = moves.reshape(*moves.shape[:-1], self.steps + 1, -1)
        for index, step in enumerate(by_step.unbind(-2)):
            parts: dict[str, Tensor] = {}
            start = 0
            for name, size in self.moved_by.items():
                part = step[..., start : start + size]
                parts[name] = part.squeeze(-1) > 0 if name.endswith(PRESENT) else part
                start += size
            yield self.steps + 1 - index, parts

    def _moved(
        self,
        values: Values,
        step: Mapping[str, Tensor],
        mean: Tensor,
        covariance: Tensor,
        is_due: Tensor,
    ) -> tuple[Tensor, Tensor]:
        """The belief after one step, in the rows ``(*B, 1)`` where it is due."""
        # Predict with what moved it then, and correct by what was on time.
        belief = {**values, **step, self.mean: mean, self.covariance: covariance}
        moved, transition = self._predicted_mean(belief)
        spread = self._predicted_covariance(belief, transition)
        moved, spread, _ = self._corrected(self._prompt, belief, moved, spread)
        return (
            torch.where(is_due, moved, mean),
            torch.where(is_due.unsqueeze(-1), spread, covariance),
        )


def _per_row(value: Tensor, like: Tensor) -> Tensor:
    """A value ``(*B, size)``, or a scalar, which is one of all rows, as ``(*B, 1)``."""
    return value if value.dim() else value.expand_as(like[..., :1])


def ekf_with_delay(
    mean: str,
    covariance: str,
    *,
    delay: int,
    sensor: str | Sequence[str],
    moved_by: Mapping[str, int],
    correct: Sequence[Measurement],
    prompt: Sequence[Measurement] = (),
    **options: Any,
) -> EKF:
    """An :class:`EKF` for readings that are prompt, or a :class:`LateEKF`.

    Args:
        mean: As for :class:`EKF`.
        covariance: As for :class:`EKF`.
        delay: Largest age of a reading, steps; 0 where all are prompt.
        sensor: As for :class:`LateEKF`.
        moved_by: As for :class:`LateEKF`.
        correct: The measurements that may be late.
        prompt: Those that never are.
        **options: As for :class:`EKF`.
    """
    if not delay:
        measurements = (
            *in_turn(f"correct of {mean!r}", correct),
            *in_turn(f"prompt of {mean!r}", prompt),
        )
        return EKF(mean, covariance, correct=measurements, **options)
    late: dict[str, Any] = {"sensor": sensor, "steps": delay, "moved_by": moved_by}
    return LateEKF(mean, covariance, **late, correct=correct, prompt=prompt, **options)
