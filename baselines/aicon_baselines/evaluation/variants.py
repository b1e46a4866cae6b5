"""Variants of a task's policy, written as text: a preset, or options with their values."""

import ast
from collections.abc import Sequence
from typing import Any

from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.agents.registry import Factory, factory
from aicon_baselines.evaluation.task import Task
from aicon_torch.errors import OptionError

REFERENCE = "aicon"
"""The policy that variants start from and are compared with."""


def make_variants(task: Task, condition: str, texts: Sequence[str]) -> dict[str, Factory]:
    """Return what builds the reference and each variant; every one is built once here, so that errors come early."""
    policies = {}
    for text in (REFERENCE, *texts):
        preset, options = parse_variant(text)
        policies[text] = factory(task.name, preset, **options)
        try:
            policies[text](condition)
        except OptionError as error:
            raise ComparisonError(f"variant {text!r}: {error}") from error
    return policies


def parse_variant(text: str) -> tuple[str, dict[str, Any]]:
    """Read "no_softmax", "ratio=2.1,margin=0.07" or "no_softmax,ratio=2.1", as one reads the arguments of a call.

    Values are Python literals; a word alone is a string, as in "resolution=sum".

    Returns:
        The preset, `REFERENCE` if none is named, and the options.
    """
    forms = "'preset', 'option=value,option=value' or 'preset,option=value'"
    try:
        call = ast.parse(f"variant({text})", mode="eval").body
        if not isinstance(call, ast.Call) or len(call.args) > 1 or not text.strip():
            raise ValueError(text)
        preset = _value(call.args[0]) if call.args else REFERENCE
        return preset, {keyword.arg: _value(keyword.value) for keyword in call.keywords if keyword.arg}
    except (SyntaxError, ValueError) as error:
        raise ComparisonError(f"a variant is written {forms}, not {text!r}") from error


def _value(node: ast.expr) -> Any:
    return node.id if isinstance(node, ast.Name) else ast.literal_eval(node)
