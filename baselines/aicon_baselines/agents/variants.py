"""Variants of a task's policy, written as text: a policy's name, or options with their values."""

import ast
from collections.abc import Sequence
from typing import Any

from aicon_baselines.agents.registry import factory
from aicon_baselines.evaluation.errors import ComparisonError
from aicon_baselines.evaluation.predictor import Factory
from aicon_baselines.evaluation.task import Task

REFERENCE = "aicon"
"""The policy that variants start from and are compared with."""


def make_variants(task: Task, condition: str, texts: Sequence[str]) -> dict[str, Factory]:
    """Return what builds the reference and each variant, by its text, the reference first.

    Every one is built once here, so that errors come early.
    """
    from aicon_torch.errors import OptionError

    policies: dict[str, Factory] = {}
    for text in (REFERENCE, *texts):
        name, options = parse_variant(text)
        policies[text] = factory(task.name, name, **options)

        try:
            policies[text](condition)
        except OptionError as error:
            raise ComparisonError(f"variant {text!r}: {error}") from error
    return policies


def parse_variant(text: str) -> tuple[str, dict[str, Any]]:
    """Read "steepest", "law.step=0.5,max_speed=0.3" or "steepest,max_speed=0.3".

    Options are named as in `make_policy`, by dotted paths where they lie deeper. Values are Python
    literals; a word alone is a string, as in "resolution.projector=oblique". No option has two.

    Returns:
        The name of the policy, `REFERENCE` if none is named, and the options.
    """
    policy, options = REFERENCE, {}
    for index, part in enumerate(_split(text)):
        name, equals, value = part.partition("=")
        name = name.strip()

        # Only the first part may be a policy, and a policy has no value.
        if not equals and index == 0 and name.isidentifier():
            policy = name
        elif equals and name not in options and all(map(str.isidentifier, name.split("."))):
            options[name] = _parse_value(value.strip(), text)
        else:
            raise _refusal(text)
    return policy, options


def _split(text: str) -> list[str]:
    """Split at the commas that are in no bracket."""
    parts, depth = [""], 0
    for character in text:
        depth += (character in "([{") - (character in ")]}")
        if character == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += character
    return parts


def _parse_value(value: str, text: str) -> Any:
    """Read a literal, or a word as a string."""
    try:
        return ast.literal_eval(value)
    except (SyntaxError, ValueError, TypeError) as error:
        if value.isidentifier():
            return value
        raise _refusal(text) from error


def _refusal(text: str) -> ComparisonError:
    forms = "'policy', 'option=value,option=value' or 'policy,option=value'"
    return ComparisonError(f"a variant is written {forms}, not {text!r}")
