"""The navigation figure: from the episode to the files."""

from pathlib import Path

from aicon_baselines.figures.nav2d.film import draw_film
from aicon_baselines.figures.nav2d.panels import choose_panels, summarize
from aicon_baselines.figures.nav2d.recording import record
from aicon_baselines.figures.nav2d.rollout_picture import draw_rollout
from aicon_baselines.figures.summary import FigureFiles, FigureSummary
from aicon_torch import make_policy


def make_figure(
    out: Path,
    seed: int = 1006,
    video: str = "mp4",
    *,
    map_name: str = "u_trap_2",
    spacing: float = 0.04,
    progress: bool = True,
) -> FigureSummary:
    """Roll the policy out and save `nav2d_rollout.png`, `.json` and, unless "none", the video.

    Args:
        out: Folder, made if it does not exist.
        seed: Seed of the map and of the noise.
        video: One of `aicon_baselines.figures.VIDEO_FORMATS`.
        map_name: Class of the map.
        spacing: Distance of the sampled positions in the picture, m; the video's are 1.5 times as
            far apart.
        progress: Whether to show progress bars, on a terminal only.

    Raises:
        ComparisonError: If the class of maps or the format of the video is unknown, the rollout is
            too short for six panels, or imageio is not installed and the video is an mp4.
    """
    files = FigureFiles(out, "nav2d_rollout", video)

    # The episode, and what the figure is to show of it.
    recording = record(make_policy("nav2d").compile(), map_name, seed, progress=progress)
    panels = choose_panels(recording)
    numbers = summarize(recording, panels)

    # The picture, and the film of the whole episode.
    draw_rollout(recording, panels, files.picture, spacing, progress=progress)
    if files.film is not None:
        draw_film(recording, files.film, 1.5 * spacing, progress=progress)

    length = f"{numbers['path_length_m']} m"
    headline = f"{recording.ending} after {numbers['duration_s']} s and {length}"
    return files.summary(headline, numbers)
