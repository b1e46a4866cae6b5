"""The trained policies that lie in the repository, in `baselines/checkpoints`."""

from pathlib import Path

from aicon_baselines.evaluation.errors import ComparisonError

_CHECKPOINTS = Path(__file__).parents[2] / "checkpoints"
_FOLDERS = {
    ("diffusion", "pusht"): "diffusion_pusht_keypoints",
    ("sb3", "pusht"): "ppo_pusht",
    ("sb3", "nav2d"): "ppo_nav2d",
}

PUBLISHED_DIFFUSION = "lerobot/diffusion_pusht@84a7c23178445c6bbf7e1a884ff497017910f653"
"""LeRobot's own policy for pushT on the Hugging Face hub, at its newest commit; it sees pixels."""

_OTHERS = {
    "diffusion": f"LeRobot's published one: --diffusion-path {PUBLISHED_DIFFUSION}",
    "sb3": "train one: python scripts/train_sb3.py --task {task} --out FOLDER",
}


def shipped_folder(kind: str, task: str) -> Path:
    """Return the folder of the policy that is meant where none is named.

    Args:
        kind: "diffusion" or "sb3".
        task: Name of the task.

    Raises:
        ComparisonError: If none was trained for the task, or it is not part of this installation.
    """
    name = _FOLDERS.get((kind, task))
    if name is None:
        trained = ", ".join(other for of_kind, other in _FOLDERS if of_kind == kind)
        raise ComparisonError(
            f"no policy {kind!r} was trained for {task}, only for {trained}; your own: "
            f"--{kind}-path FOLDER"
        )

    folder = _CHECKPOINTS / name
    if not folder.is_dir():
        raise ComparisonError(
            f"the trained policy {kind!r} for {task} is not part of this installation: take the "
            f"folder baselines/checkpoints/{name} of the repository, --{kind}-path {name}, or "
            + _OTHERS[kind].format(task=task)
        )
    return folder
