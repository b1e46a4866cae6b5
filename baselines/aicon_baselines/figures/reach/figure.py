"""The figure of arms that reach: from the episodes to the files."""

from pathlib import Path
from typing import Any

from aicon_baselines.figures.reach.film import draw_film
from aicon_baselines.figures.reach.picture import draw_picture
from aicon_baselines.figures.reach.recording import ReachRecording, record
from aicon_baselines.figures.rendering import check_video
from aicon_baselines.figures.summary import FigureSummary
from aicon_baselines.tasks.reach import ROBOTS, TASK
from aicon_torch import make_policy

FILMED = "ur5"
"""The robot of the film."""


def make_figure(
    out: Path,
    seed: int = 1020,
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
    options: dict[str, Any] = {"seed": seed, "horizon": horizon, "progress": progress}
    recordings = [_record(robot, f"{robot}_pose_home", **options) for robot in ROBOTS]
    draw_picture(recordings, picture)
    files = [picture]

    # The film has something in the way.
    if video != "none":
        film = picture.with_suffix(f".{video}")
        recording = _record(FILMED, f"{FILMED}_pose_home_ball", balls=1, **options)
        draw_film(recording, film)
        files.append(film)

    endings, numbers = [], {}
    for recording in recordings:
        ending = "arrived" if recording.success else "did not arrive"
        endings.append(f"{recording.robot} {ending} after {recording.times[-1]:.1f} s")
        numbers[recording.robot] = float(recording.times[-1])
    return FigureSummary("; ".join(endings), {"seed": seed, "times_s": numbers}, tuple(files))


def _record(robot: str, condition: str, **options: Any) -> ReachRecording:
    """An episode of a robot in a condition of the task."""
    policy = make_policy("reach", **TASK.policy_options(condition))
    return record(policy, robot, **options)
