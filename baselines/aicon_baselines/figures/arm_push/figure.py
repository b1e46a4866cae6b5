"""The arm's film: from the episode to the files."""

from pathlib import Path

from aicon_baselines.figures.arm_push.film import draw_film, draw_still
from aicon_baselines.figures.arm_push.recording import record
from aicon_baselines.figures.rendering import check_video
from aicon_baselines.figures.summary import FigureSummary
from aicon_baselines.tasks.arm_push import TASK
from aicon_torch import make_policy


def make_figure(
    out: Path,
    seed: int = 1000,
    video: str = "mp4",
    *,
    horizon: int = 6_000,
    progress: bool = True,
) -> FigureSummary:
    """Run an episode and save `arm_push_film.png`, of its middle, and, unless "none", the video.

    Args:
        out: Folder, made if it does not exist.
        seed: Seed of the episode.
        video: One of `aicon_baselines.figures.VIDEO_FORMATS`.
        horizon: Steps after which it ends.
        progress: Whether to show progress bars, on a terminal only.

    Raises:
        ComparisonError: If the format of the video is unknown, or imageio is not installed and the
            video is an mp4.
    """
    check_video(video)
    out.mkdir(parents=True, exist_ok=True)
    picture = out / "arm_push_film.png"

    # The episode, and the picture from its middle.
    policy = make_policy("arm_push", **TASK.policy_options("camera")).compile()
    recording = record(policy, seed, horizon, progress=progress)
    draw_still(recording, picture)
    files = [picture]

    # The film.
    if video != "none":
        film = picture.with_suffix(f".{video}")
        draw_film(recording, film, progress=progress)
        files.append(film)

    duration = float(recording.times[-1])
    headline = f"{recording.ending} after {duration:.1f} s"
    numbers = {"seed": seed, "ending": recording.ending, "duration_s": round(duration, 3)}
    return FigureSummary(headline, numbers, tuple(files))
