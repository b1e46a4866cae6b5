"""The paper's navigation figure, drawn from a real rollout: how the potential changes while the agent moves.

The agent only ever computes one gradient, the one where it is. The figure asks what it would compute elsewhere: at each
of many positions the library's own sweep runs on the memory that the agent had at that moment.
"""

import json
from pathlib import Path
from typing import Any

from tqdm import tqdm

from aicon_baselines.figures.nav2d.field import Field, clearance, sample
from aicon_baselines.figures.nav2d.grid import Grid
from aicon_baselines.figures.nav2d.panels import choose_panels, summary
from aicon_baselines.figures.nav2d.recording import Recording, record
from aicon_baselines.figures.nav2d.rollout_picture import draw_rollout
from aicon_baselines.figures.nav2d.video import draw_video, video_steps
from aicon_baselines.figures.pictures import check_video
from aicon_torch import make_policy

__all__ = [
    "Field",
    "Grid",
    "Recording",
    "choose_panels",
    "clearance",
    "draw_rollout",
    "draw_video",
    "make_figure",
    "record",
    "sample",
    "summary",
    "video_steps",
]


def make_figure(
    name: str, seed: int, out: Path, video: str = "mp4", *, spacing: float = 0.04, progress: bool = True
) -> dict[str, Any]:
    """Roll the policy out and save `nav2d_rollout.png`, `.json` and, unless it is "none", the video.

    Args:
        name: Class of the map.
        seed: Seed of the map and of the noise.
        out: Folder, made if it does not exist.
        video: One of `VIDEOS`.
        spacing: Distance of the sampled positions in the picture, m; the video's are 1.5 times as far apart.
        progress: Whether to show a progress bar, on a terminal only.

    Returns:
        The numbers that the JSON file holds.

    Raises:
        ComparisonError: If the class of maps or the kind of video is unknown, the rollout is too short for six panels,
            or imageio is not installed and the video is an mp4.
    """
    check_video(video)
    out.mkdir(parents=True, exist_ok=True)
    path = out / "nav2d_rollout.png"
    with tqdm(unit="step", desc="rollout", disable=None if progress else True) as bar:
        recording = record(make_policy("nav2d"), name, seed, bar.update)
        panels = choose_panels(recording)
        numbers = summary(recording, panels)
        path.with_suffix(".json").write_text(json.dumps(numbers, indent=2) + "\n")
        bar.reset(len(panels))
        bar.set_description("picture")
        draw_rollout(recording, panels, path, spacing, bar.update)
        if video != "none":
            moving = path.with_suffix(f".{video}")
            bar.reset(len(video_steps(recording, moving)))
            bar.set_description("video")
            draw_video(recording, moving, 1.5 * spacing, bar.update)
    return numbers
