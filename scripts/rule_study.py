"""What studies of rules share: the rules themselves."""

from typing import Any


def rules() -> dict[str, Any]:
    """What happens to gradients that meet; nobody explores."""
    from aicon_torch import NullspaceProjection, SteepestPath, Sum

    return {
        "sum": Sum(),
        "projection": NullspaceProjection(temperature=None, exploration=None),
        "projection, softmax": NullspaceProjection(exploration=None),
        "softmax sum": NullspaceProjection(projector="none", exploration=None),
        "steepest path": SteepestPath(),
    }
