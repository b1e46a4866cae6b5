"""The paper's pushing figure, drawn from a real episode: the gradients that meet at the pusher, and what comes of them.

Everything drawn is what happened or what the policy knew: contacts, likelihoods, gradients and the commanded motion are
read off the memory that it returned in each step.
"""

import json
from pathlib import Path
from typing import Any

from tqdm import tqdm

from aicon_baselines.figures.pictures import check_video
from aicon_baselines.figures.pusht.panels import at_corners, choose_panels, phase, summary
from aicon_baselines.figures.pusht.recording import Recording, record
from aicon_baselines.figures.pusht.rollout_picture import draw_rollout
from aicon_baselines.figures.pusht.video import draw_video
from aicon_torch import make_policy

__all__ = [
    "Recording",
    "at_corners",
    "choose_panels",
    "draw_rollout",
    "draw_video",
    "make_figure",
    "phase",
    "record",
    "summary",
]


def make_figure(seed: int, out: Path, video: str = "mp4", *, progress: bool = True) -> dict[str, Any]:
    """Roll the policy out and save `pusht_rollout.png`, `.json` and, unless it is "none", the video.

    Args:
        seed: Seed of the episode.
        out: Folder, made if it does not exist.
        video: One of `aicon_baselines.figures.pictures.VIDEOS`.
        progress: Whether to show a progress bar, on a terminal only.

    Returns:
        The numbers that the JSON file holds.

    Raises:
        ComparisonError: If the kind of video is unknown, the episode is too short for six panels, or imageio is not
            installed and the video is an mp4.
    """
    check_video(video)
    out.mkdir(parents=True, exist_ok=True)
    path = out / "pusht_rollout.png"
    recording = record(make_policy("pusht"), seed)
    panels = choose_panels(recording)
    numbers = summary(recording, panels)
    path.with_suffix(".json").write_text(json.dumps(numbers, indent=2) + "\n")
    with tqdm(unit="picture", desc="picture", total=len(panels), disable=None if progress else True) as bar:
        draw_rollout(recording, panels, path, bar.update)
        if video != "none":
            bar.reset(recording.steps + 1)
            bar.set_description("video")
            draw_video(recording, path.with_suffix(f".{video}"), bar.update)
    return numbers
