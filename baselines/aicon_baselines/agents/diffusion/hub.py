"""Where a saved policy is: a folder, or a repository of the Hugging Face hub."""

import re
from pathlib import Path
from urllib.error import HTTPError, URLError
from urllib.request import Request, urlopen

from aicon_baselines.agents.diffusion.installed import import_lerobot
from aicon_baselines.evaluation.errors import ComparisonError

_PROBE = 3.0  # s
_NAME = re.compile(r"[\w.-]+/[\w.-]+")
_FILES = ["*.json", "*.safetensors"]


def locate(source: str) -> Path:
    """Return the folder of a policy.

    Args:
        source: A folder, or the name of a repository such as "lerobot/diffusion_pusht", which is downloaded once.

    Returns:
        The folder; a hub that cannot be reached is an error that says what to download, and where to put it.
    """
    folder = Path(source)
    if folder.is_dir():
        return folder.resolve()
    if not _NAME.fullmatch(source):
        raise ComparisonError(
            f"there is no folder {source}, and it is no name OWNER/REPOSITORY of the hub either; train a policy: "
            "python scripts/train_diffusion.py --data DEMONSTRATIONS --out FOLDER"
        )
    import_lerobot("policies.factory")  # says what to install, as the hub's client comes with LeRobot
    return _downloaded(source)


def _downloaded(name: str) -> Path:
    from huggingface_hub import constants, snapshot_download
    from huggingface_hub.errors import HfHubHTTPError, LocalEntryNotFoundError

    try:
        found = Path(snapshot_download(name, allow_patterns=_FILES, local_files_only=True))
        if (found / "model.safetensors").exists():
            return found
    except LocalEntryNotFoundError:
        pass
    reason = "HF_HUB_OFFLINE is set" if constants.HF_HUB_OFFLINE else _unreachable(constants.ENDPOINT)
    if not reason:
        try:
            return Path(snapshot_download(name, allow_patterns=_FILES))
        except (HfHubHTTPError, LocalEntryNotFoundError, OSError) as error:
            reason = str(error).strip().splitlines()[0]
    place = Path("runs", name.split("/")[1])
    raise ComparisonError(
        f"cannot load {name} ({reason}), and there is no such folder. Download config.json, model.safetensors and, if "
        f"there are any, policy_*.json and policy_*.safetensors from {constants.ENDPOINT}/{name}/tree/main on another "
        f"machine, put them into a folder, for example {place}, and give that: --diffusion-path {place}"
    )


def _unreachable(endpoint: str) -> str:
    """Return why the hub cannot be reached; empty if it answers, whatever it says."""
    try:
        with urlopen(Request(endpoint, method="HEAD"), timeout=_PROBE):
            return ""
    except HTTPError:
        return ""
    except (URLError, OSError) as error:
        return f"{endpoint} does not answer: {getattr(error, 'reason', error)}"
