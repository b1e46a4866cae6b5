"""Drawing a graph."""

from aicon_torch.graph.build import Graph
from aicon_torch.graph.declaration import Declaration


def flowchart(declaration: Declaration, graph: Graph) -> str:
    """A graph as a Mermaid flowchart: sensors, actuators, estimators, goals, and who reads whom."""
    lines = ["flowchart LR"]

    # The nodes, each kind with its shape.
    for name, sensor in declaration.sensors.items():
        lines.append(f"  {name}[/{name}, {sensor.unit}/]")
    for name, actuator in declaration.actuators.items():
        lines.append(f"  {name}[\\{name}, {actuator.unit}\\]")
    for estimator in graph.estimators:
        lines.append(f"  {estimator.outputs[0]}({'<br/>'.join(estimator.outputs)})")
    for name in declaration.goals:
        lines.append(f"  {name}{{{{{name}}}}}")

    # The arrows.
    for estimator in graph.estimators:
        lines += _arrows(estimator.outputs[0], estimator.inputs, graph)
    for name, goal in declaration.goals.items():
        lines += _arrows(name, goal.inputs, graph)
    return "\n".join(lines)


def _arrows(reader: str, inputs: tuple[str, ...], graph: Graph) -> list[str]:
    """An arrow from each node that a node reads, but for itself."""
    sources: dict[str, None] = {}
    for name in inputs:
        if name != "dt":
            owner = graph.owners.get(name)
            sources[owner.outputs[0] if owner is not None else name] = None
    return [f"  {source} --> {reader}" for source in sources if source != reader]
