"""A figure that changes from step to step."""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator

from matplotlib.figure import Figure

from aicon_baselines.figures.rendering import Frame, render


class Film(ABC):
    """A figure that can be brought to any step of an episode.

    Attributes:
        figure: The figure.
    """

    figure: Figure

    @abstractmethod
    def show(self, step: int) -> None:
        """Bring the figure to a step."""

    def frames(self, steps: Iterable[int], hold: int = 0) -> Iterator[Frame]:
        """Render the figure at each step, and the last one `hold` times more."""
        for step in steps:
            self.show(step)
            frame = render(self.figure)
            yield frame

        for _ in range(hold):
            yield frame
