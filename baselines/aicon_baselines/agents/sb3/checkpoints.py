"""Saving an agent during training."""

from collections.abc import Callable

import numpy as np
from stable_baselines3.common.callbacks import BaseCallback
from tqdm import tqdm


class CheckpointsWithProgress(BaseCallback):
    """Saves every so many steps and at the end, and shows a bar, on a terminal only.

    Args:
        total: Steps at the end of the training, for the bar.
        interval: Steps between two saves.
        save: Called without arguments to save.
        report: Called with a line of text after each save but the last.
    """

    def __init__(
        self,
        total: int,
        interval: int,
        save: Callable[[], None],
        report: Callable[[str], None] | None = None,
    ) -> None:
        super().__init__()
        self._total = total
        self._interval = interval
        self._save = save
        self._report = report

    def _on_training_start(self) -> None:
        self._last_saved = self.model.num_timesteps
        self._bar = tqdm(
            initial=self._last_saved,
            total=self._total,
            unit=" steps",
            smoothing=0.05,
            disable=None,  # unless this is a terminal
        )

    def _on_step(self) -> bool:
        self._bar.update(self.num_timesteps - self._bar.n)

        if self.num_timesteps - self._last_saved >= self._interval:
            self._last_saved = self.num_timesteps
            self._save()
            self._tell()

        return True

    def _on_training_end(self) -> None:
        self._bar.close()
        self._save()

    def _tell(self) -> None:
        """Report how the last 100 training episodes went."""
        if self._report is None:
            return

        self._bar.clear()  # or the line would stand beside it
        self._report(f"{self.num_timesteps:,} steps: {self._summarize_episodes()}")

    def _summarize_episodes(self) -> str:
        rewards = [episode["r"] for episode in self.model.ep_info_buffer or ()]
        successes = list(self.model.ep_success_buffer or ())
        if not rewards or not successes:
            return "no episode has ended yet"

        success_rate = 100.0 * np.mean(successes)
        return f"success {success_rate:.0f} %, reward {np.mean(rewards):.2f} (with exploration)"
