"""The graph of a world model: declared by a user, built and checked once, run step by step."""

from aicon_torch.graph.build import Graph, build_graph
from aicon_torch.graph.declaration import Declaration
from aicon_torch.graph.filtering import Filtered, Innovations
from aicon_torch.graph.information import Information
from aicon_torch.graph.paths import Edge, Path, PathTable
from aicon_torch.graph.world_model import LocalGraph, LocalGraphs, WorldModel

__all__ = [
    "Declaration",
    "Edge",
    "Filtered",
    "Graph",
    "Information",
    "Innovations",
    "LocalGraph",
    "LocalGraphs",
    "Path",
    "PathTable",
    "WorldModel",
    "build_graph",
]
