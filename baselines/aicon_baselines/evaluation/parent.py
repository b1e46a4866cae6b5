"""Worker processes that end when the process that started them does, however it ended."""

import os
import time
from threading import Thread

_INTERVAL = 0.2  # s between two looks at the parent


def end_with(parent: int) -> None:
    """End this process soon after its parent.

    The parent may be killed without a chance to tell anyone. Its children then belong to another
    process, which is how they notice.

    Args:
        parent: Process number of the parent; where that is this process itself, nothing happens.
    """
    if os.getpid() != parent:
        Thread(target=_watch, args=(parent,), daemon=True).start()


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(_INTERVAL)
    os._exit(1)  # at once: there is nobody left to tell
