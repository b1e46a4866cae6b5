"""From a traced graph of tensor operations to a program of numbers."""

import operator
from collections.abc import Sequence
from typing import Any

import torch
from torch import Tensor
from torch.fx import GraphModule, Node

from aicon_torch.errors import GraphError
from aicon_torch.export.codegen.arrays import Array, Writer, kind_of
from aicon_torch.export.codegen.creation import CREATION
from aicon_torch.export.codegen.indexing import INDEXING
from aicon_torch.export.codegen.networks import NETWORKS
from aicon_torch.export.codegen.operators import ELEMENTWISE, Translation
from aicon_torch.export.codegen.scalars import Kind
from aicon_torch.export.codegen.selection import SELECTION
from aicon_torch.export.codegen.solving import SOLVING

TRANSLATIONS: dict[str, Translation] = {
    **ELEMENTWISE,
    **INDEXING,
    **SELECTION,
    **SOLVING,
    **CREATION,
    **NETWORKS,
}
"""The translation of each operator, by its name in aten without the overload."""


def translate(graph: GraphModule, writer: Writer, inputs: Sequence[Array]) -> list[Array]:
    """Write what a graph does into a program.

    Args:
        graph: A flat graph of operations on tensors of known shapes, traced by ``make_fx``.
        writer: Writes into the program.
        inputs: The numbers of each input.

    Returns:
        The numbers of each output.

    Raises:
        GraphError: If there is no translation of an operation.
    """
    known: dict[Node, Any] = {}
    remaining = iter(inputs)

    for node in graph.graph.nodes:
        if node.op == "placeholder":
            known[node] = next(remaining)
        elif node.op == "get_attr":
            known[node] = writer.array(getattr(graph, str(node.target)))
        elif node.op == "call_function":
            arguments = torch.fx.map_arg((node.args, node.kwargs), lambda n: known[n])
            known[node] = _apply(node, writer, *_plain(arguments))
        elif node.op == "output":
            outputs = torch.fx.map_arg(node.args[0], lambda n: known[n])
    return [writer.array(output) for output in outputs]


def _apply(node: Node, writer: Writer, args: tuple[Any, ...], kwargs: dict[str, Any]) -> Any:
    """What one operation makes of its arguments."""
    if node.target is operator.getitem:
        return args[0][args[1]]

    name = _name_of(node)
    changes_in_place = name not in TRANSLATIONS and name.endswith("_")
    translation = TRANSLATIONS.get(name.removesuffix("_") if changes_in_place else name)
    if translation is None:
        raise GraphError(f"{_what(node)} cannot be exported: it has no translation to C.")

    try:
        result = translation(writer, _kind(node), *args, **kwargs)
    except NotImplementedError as error:
        raise GraphError(f"{_what(node)} cannot be exported {error}.") from error
    if changes_in_place:
        args[0][...] = result
        return args[0]
    return result


def _name_of(node: Node) -> str:
    """``add`` of ``aten::add.Tensor``."""
    schema = getattr(node.target, "_schema", None)
    return str(node.target) if schema is None else str(schema.name).split("::")[-1]


def _kind(node: Node) -> Kind:
    """The kind of the (first) result."""
    value = node.meta["val"]
    while not isinstance(value, Tensor):
        value = value[0]
    return kind_of(value.dtype)


def _what(node: Node) -> str:
    """The operation and the size of its result, for an error."""
    value = node.meta.get("val")
    shape = f" of shape {tuple(value.shape)}" if isinstance(value, Tensor) else ""
    return f"The operation {_name_of(node)!r}{shape}"


def _plain(arguments: Any) -> Any:
    """Arguments with Python's own tuples and dictionaries."""
    args, kwargs = arguments
    return tuple(args), dict(kwargs)
