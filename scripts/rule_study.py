"""What studies of rules share: the rules themselves."""

from collections.abc import Mapping

from aicon_torch import NullspaceProjection, Resolution, SteepestPath, Sum

RULES: Mapping[str, Resolution] = {
    "sum": Sum(),
    "projection": NullspaceProjection(temperature=None, exploration=None),
    "projection, softmax": NullspaceProjection(exploration=None),
    "softmax sum": NullspaceProjection(projector="none", exploration=None),
    "steepest path": SteepestPath(),
}
"""What happens to gradients that meet; nobody explores."""
