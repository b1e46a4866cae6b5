"""A table of inputs as a loop, where an item for each would say nothing by itself."""

import functools
import inspect
from collections.abc import Callable, Mapping
from typing import Any


def for_each(name: str, table: Mapping[str, Any]) -> Callable[[Callable[..., None]], Any]:
    """Run a test for each value of a table; a failure says which it was."""

    def decorate(test: Callable[..., None]) -> Any:
        @functools.wraps(test)
        def loop(**arguments: Any) -> None:
            for label, value in table.items():
                try:
                    test(**arguments, **{name: value})
                except BaseException as error:
                    error.add_note(f"{name}: {label}")
                    raise

        # What pytest fills in: all but what the loop does.
        signature = inspect.signature(test)
        others = [value for key, value in signature.parameters.items() if key != name]
        loop.__signature__ = signature.replace(parameters=others)  # type: ignore[attr-defined]
        return loop

    return decorate
