"""Drawing a world model."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from aicon_torch.graph import WorldModel


def flowchart(model: WorldModel) -> str:
    """The graph as a Mermaid flowchart: sensors and actuators, estimators, goals, and who reads whom."""
    lines = ["flowchart LR"]
    lines += [f"  {name}[/{name}, {sensor.unit}/]" for name, sensor in model.sensors.items()]
    lines += [f"  {name}[\\{name}, {actuator.unit}\\]" for name, actuator in model.actuators.items()]
    lines += [f"  {node.outputs[0]}({'<br/>'.join(node.outputs)})" for node in model.nodes]
    lines += [f"  {name}{{{{{name}}}}}" for name in model.goals]
    readers: list[tuple[str, Iterable[str]]] = [(node.outputs[0], node.inputs) for node in model.nodes]
    readers += [(name, goal.inputs) for name, goal in model.goals.items()]
    for reader, inputs in readers:
        sources = dict.fromkeys(
            model.owners[name].outputs[0] if name in model.owners else name for name in inputs if name != "dt"
        )
        lines += [f"  {source} --> {reader}" for source in sources if source != reader]
    return "\n".join(lines)
