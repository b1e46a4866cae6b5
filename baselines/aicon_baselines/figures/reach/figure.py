"""The figure of arms that reach: from the episodes to the files."""

from pathlib import Path

import numpy as np

from aicon_baselines.figures.reach.picture import draw_picture
from aicon_baselines.figures.reach.recording import record
from aicon_baselines.figures.rendering import check_video, save_video
from aicon_baselines.figures.summary import FigureSummary
from aicon_baselines.tasks.reach import ROBOTS, TASK
from aicon_torch import make_policy

_PALETTE = np.stack(np.meshgrid(*[np.linspace(0, 1, 6)] * 3), axis=-1).reshape(-1, 3)
"""The colours of a gif: six levels of red, green and blue each."""


def make_figure(
    out: Path,
    seed: int = 1000,
    video: str = "mp4",
    *,
    horizon: int = 1_000,
    progress: bool = True,
) -> FigureSummary:
    """Let each robot reach for a pose and save `reach.png` and, unless "none", the video.

    Args:
        out: Folder, made if it does not exist.
        seed: Seed of the episodes.
        video: One of `aicon_baselines.figures.VIDEO_FORMATS`.
        horizon: Steps after which an episode ends.
        progress: Whether to show progress bars, on a terminal only.

    Raises:
        ComparisonError: If the format of the video is unknown, or imageio is not installed and the
            video is an mp4.
    """
    check_video(video)
    out.mkdir(parents=True, exist_ok=True)
    picture = out / "reach.png"

    # The same numbers for every robot.
    recordings = []
    for robot in ROBOTS:
        policy = make_policy("reach", **TASK.policy_options(f"{robot}_pose_home"))
        recordings.append(record(policy, robot, seed, horizon, progress=progress))
    draw_picture(recordings, picture)
    files = [picture]

    # One after the other.
    if video != "none":
        film = picture.with_suffix(f".{video}")
        frames = [frame for recording in recordings for frame in recording.frames]
        save_video(frames, film, 25, _PALETTE)
        files.append(film)

    endings, numbers = [], {}
    for recording in recordings:
        ending = "arrived" if recording.success else "did not arrive"
        endings.append(f"{recording.robot} {ending} after {recording.times[-1]:.1f} s")
        numbers[recording.robot] = float(recording.times[-1])
    return FigureSummary("; ".join(endings), {"seed": seed, "times_s": numbers}, tuple(files))
