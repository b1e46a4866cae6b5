"""What a page holds of a policy: the module, by gzip, as text, and the paths that meet."""

import base64
import gzip
import tempfile
from pathlib import Path
from typing import Any

import torch

from aicon_torch import Policy
from aicon_torch.export.codegen import compile_library
from aicon_torch.export.codegen.compiler import identity
from aicon_torch.export.codegen.targets import WEB
from building.scripts import KEPT

COMPILED = KEPT / "policies"
"""Where modules are kept that were compiled before, by their source and how it was compiled."""


def pack(policy: Policy) -> dict[str, Any]:
    """A policy as an entry of a page's data."""
    module = gzip.compress(compiled(policy), mtime=0)
    return {"wasm": base64.b64encode(module).decode(), "paths": paths_that_meet(policy)}


def compiled(policy: Policy) -> bytes:
    """The module of a policy."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "policy.c")
        policy.export(path)
        source = path.read_text()

    COMPILED.mkdir(parents=True, exist_ok=True)
    module = COMPILED / f"{identity(source, WEB)}.wasm"
    if not module.is_file():
        compile_library(source, module, WEB)
    return module.read_bytes()


def paths_that_meet(policy: Policy) -> dict[str, list[list[str]]]:
    """For each quantity where gradients meet the path of each of them, in their order."""
    model = policy.model
    readings = {}
    for name, sensor in model.sensors.items():
        if name != model.clock:
            readings[sensor.key or name] = torch.full((sensor.size,), 0.5, dtype=torch.float64)

    _, memory = policy.predict(readings)
    met = policy.trace(memory).quantities
    meeting = [name for name in met if f"{name}/gradients" in memory]
    return {name: [list(path) for path in met[name].paths] for name in meeting}
