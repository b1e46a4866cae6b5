"""The graph: built and checked once, then run step by step."""

from aicon_torch.graph.checks import attempt, check_names, names, ordered
from aicon_torch.graph.paths import Edge, Path, PathTable
from aicon_torch.graph.world_model import LocalGraph, LocalGraphs, WorldModel

__all__ = ["Edge", "LocalGraph", "LocalGraphs", "Path", "PathTable", "WorldModel", "attempt", "check_names", "names", "ordered"]
