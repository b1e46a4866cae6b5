"""Demonstrations as a dataset of LeRobot."""

from collections.abc import Iterable
from itertools import islice
from pathlib import Path
from typing import Any

from aicon_baselines.agents.diffusion.dataset import FEATURES
from aicon_baselines.agents.diffusion.demonstrations import Demonstration
from aicon_baselines.agents.diffusion.feature_names import ACTION, KEYPOINTS, PIXELS, STATE
from aicon_baselines.agents.diffusion.lerobot_import import import_lerobot
from aicon_baselines.agents.diffusion.recording_config import RecordingConfig

_FRAMES_PER_SECOND = 10
_TASK = "Push the T onto its target."
_SHOWN = {"keypoints": KEYPOINTS, "pixels": PIXELS}


def write_dataset(
    config: RecordingConfig, episodes: Iterable[Demonstration], folder: Path, name: str
) -> None:
    """Write as many demonstrations as are wanted as a `LeRobotDataset`.

    Args:
        config: What to write.
        episodes: The demonstrations.
        folder: Folder of the dataset, which does not exist yet.
        name: Name of the dataset.
    """
    from datasets import disable_progress_bars

    disable_progress_bars()  # one for each episode with pictures

    shown = [_SHOWN[observation] for observation in config.observations]
    names = [STATE, *shown, ACTION]
    dataset: Any = import_lerobot("datasets.lerobot_dataset").LeRobotDataset.create(
        repo_id=f"local/{name}",
        fps=_FRAMES_PER_SECOND,
        root=folder,
        features={feature: FEATURES[feature] for feature in names},
        use_videos=False,
    )

    # Frames belong to an episode by being added before it is saved.
    for episode in islice(episodes, config.episodes):
        for t in range(len(episode[ACTION])):
            frame = {feature: episode[feature][t] for feature in names}
            dataset.add_frame(frame | {"task": _TASK})
        dataset.save_episode()

    dataset.finalize()
