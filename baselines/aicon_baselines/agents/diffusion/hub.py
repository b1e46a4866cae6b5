"""Where a saved policy is: a folder, or a repository of the Hugging Face hub."""

import re
from pathlib import Path
from urllib.error import HTTPError, URLError
from urllib.request import Request, urlopen

from aicon_baselines.agents.diffusion.checkpoint import WEIGHTS
from aicon_baselines.agents.diffusion.lerobot_names import import_lerobot
from aicon_baselines.evaluation.errors import ComparisonError

_TIMEOUT = 3.0  # s
_SOURCE = re.compile(r"(?P<repository>[\w.-]+/[\w.-]+)(@(?P<commit>[0-9a-f]{40}))?")
_FILES = ["*.json", "*.safetensors"]


def locate(source: str) -> Path:
    """Return the folder of a policy.

    Args:
        source: A folder, or OWNER/REPOSITORY@COMMIT, which is downloaded once. The commit, all 40
            digits of it, pins what comes: a name alone is whatever its owner puts there next.

    Raises:
        ComparisonError: Where there is neither; if the hub cannot be reached, it says what to
            download, and where to put it.
    """
    folder = Path(source)
    if folder.is_dir():
        return folder.resolve()

    named = _SOURCE.fullmatch(source)
    if named is None:
        raise ComparisonError(
            f"there is no folder {source}, and it is no OWNER/REPOSITORY@COMMIT of the hub either; "
            "train a policy: python scripts/train_diffusion.py --data DEMONSTRATIONS --out FOLDER"
        )

    # A branch may be moved to anything: only a commit says what is downloaded.
    repository, commit = named["repository"], named["commit"]
    if commit is None:
        raise ComparisonError(
            f"there is no folder {source}; a download needs the commit that is meant, "
            f"{source}@COMMIT with all 40 digits: choose one of "
            f"https://huggingface.co/{source}/commits/main"
        )

    import_lerobot("policies.factory")  # says what to install: the hub's client comes with LeRobot
    return _download(repository, commit)


def _download(repository: str, commit: str) -> Path:
    """Return the folder of what is downloaded, or was before."""
    from huggingface_hub import constants, snapshot_download
    from huggingface_hub.errors import HfHubHTTPError, LocalEntryNotFoundError

    # The client itself would try for minutes.
    endpoint = constants.ENDPOINT
    is_offline = constants.HF_HUB_OFFLINE
    reason = "HF_HUB_OFFLINE is set" if is_offline else _why_unreachable(endpoint)

    try:
        folder = snapshot_download(
            repository, revision=commit, allow_patterns=_FILES, local_files_only=bool(reason)
        )
    except (HfHubHTTPError, LocalEntryNotFoundError, OSError) as error:
        reason = reason or str(error).strip().splitlines()[0]
        raise _not_downloaded(repository, commit, reason, endpoint) from error

    # A download that was interrupted has a folder, too.
    if not Path(folder, WEIGHTS).exists():
        raise _not_downloaded(repository, commit, reason or f"no {WEIGHTS} in it", endpoint)
    return Path(folder)


def _not_downloaded(repository: str, commit: str, reason: str, endpoint: str) -> ComparisonError:
    """Return an error that says what to download elsewhere, and where to put it."""
    folder = Path("runs", repository.split("/")[1])
    return ComparisonError(
        f"cannot load {repository} ({reason}), and there is no such folder. Download config.json, "
        "model.safetensors and, if there are any, policy_*.json and policy_*.safetensors from "
        f"{endpoint}/{repository}/tree/{commit} on another machine, put them into a folder, for "
        f"example {folder}, and give that: --diffusion-path {folder}"
    )


def _why_unreachable(endpoint: str) -> str:
    """Return why the hub cannot be reached; empty if it answers, whatever it says."""
    try:
        with urlopen(Request(endpoint, method="HEAD"), timeout=_TIMEOUT):
            return ""
    except HTTPError:
        return ""
    except (URLError, OSError) as error:
        return f"{endpoint} does not answer: {getattr(error, 'reason', error)}"
