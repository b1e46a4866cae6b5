"""The pushing figure: from the episode to the files."""

from pathlib import Path

from aicon_baselines.figures.pusht.film import draw_film
from aicon_baselines.figures.pusht.panels import choose_panels, summarize
from aicon_baselines.figures.pusht.recording import record
from aicon_baselines.figures.pusht.rollout_picture import draw_rollout
from aicon_baselines.figures.summary import FigureFiles, FigureSummary
from aicon_torch import make_policy

DEFAULT_SEED = 1043
"""Of 1000 to 1059 the shortest episode that shows all six moments of the paper's figure."""


def make_figure(
    out: Path, seed: int = DEFAULT_SEED, video: str = "mp4", *, progress: bool = True
) -> FigureSummary:
    """Roll the policy out and save `pusht_rollout.png`, `.json` and, unless "none", the video.

    Args:
        out: Folder, made if it does not exist.
        seed: Seed of the episode.
        video: One of `aicon_baselines.figures.VIDEO_FORMATS`.
        progress: Whether to show progress bars, on a terminal only.

    Raises:
        ComparisonError: If the format of the video is unknown, the episode is too short for six
            panels, or imageio is not installed and the video is an mp4.
    """
    files = FigureFiles(out, "pusht_rollout", video)

    # The episode, and what the figure is to show of it.
    recording = record(make_policy("pusht").compile(), seed)
    panels = choose_panels(recording)
    numbers = summarize(recording, panels)

    # The picture, and the film of the whole episode.
    draw_rollout(recording, panels, files.picture, progress=progress)
    if files.film is not None:
        draw_film(recording, files.film, progress=progress)

    length = f"{numbers['path_length_px']} px"
    headline = f"{recording.ending} after {numbers['duration_s']} s and {length}"
    return files.summary(headline, numbers)
