"""Take steps of a policy and tell how long they took: the worker of `benchmark.py versions`.

It imports nothing but the library, so that it runs with any version of it.
"""

import json
import os
import pickle
import sys
import time
from pathlib import Path
from typing import Any

Told = dict[str, tuple[float, float]]
"""Seconds of the processor and by the clock, of what is done once."""


def work(what: dict[str, Any]) -> None:
    """Take a first step, then as many as each line asks for; answer with how long they took."""
    import torch

    import aicon_torch

    torch.set_num_threads(1)
    observations = pickle.loads(Path(what["file"]).read_bytes())
    told: Told = {}

    start = clocks()
    if "load" in what:
        policy: Any = aicon_torch.load_exported(what["load"])
    else:
        policy = aicon_torch.make_policy(what["task"], **what["options"]).compile()
    policy.predict(observations[0])
    told["first step"] = since(start)

    for file, options in what.get("exports", {}).items():
        start = clocks()
        aicon_torch.make_policy(what["task"], **options).export(file)
        told[f"export of {Path(file).stem}"] = since(start)
    print(json.dumps(told), flush=True)

    memory, taken = None, 0
    for line in sys.stdin:
        seconds = []
        for _ in range(int(line)):
            observation = observations[taken % len(observations)]
            began = time.process_time()
            _, memory = policy.predict(observation, memory)
            seconds.append(time.process_time() - began)
            taken += 1
        print(json.dumps(seconds), flush=True)


def clocks() -> tuple[float, float]:
    """Time of the processor, with that of finished compilers, and of the clock, s."""
    times = os.times()
    return sum(times[:4]), times.elapsed


def since(start: tuple[float, float]) -> tuple[float, float]:
    """What has passed on both."""
    processor, clock = clocks()
    return processor - start[0], clock - start[1]


if __name__ == "__main__":
    work(json.loads(sys.argv[1]))
