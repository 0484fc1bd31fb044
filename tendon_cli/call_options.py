"""Options of the library's functions: one that a function does not have is refused by its name."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Sequence
from functools import wraps
from typing import Any

from tendon_cli.errors import UsageError
from tendon_cli.units import described


def check_options(function: str, given: Iterable[str], known: Sequence[str]) -> None:
    """Raise UsageError for an option that a function does not have.

    Args:
        function: Public name of the function, such as "sweep".
        given: Names of the options given.
        known: Names of its arguments.
    """
    for name in given:
        if name not in known:
            hint = f"it has {', '.join(known)}"
            raise UsageError(f"{function}() has no option {described(name)}", hint=hint)


def public(function: Callable[..., Any], name: str) -> Callable[..., Any]:
    """Return a function of the library under its public name, by which errors call it.

    The result refuses options that the function does not have by a `UsageError`. A function that
    takes any option, such as `plot`, checks them by itself.
    """
    parameters = inspect.signature(function).parameters
    takes_any = any(one.kind is one.VAR_KEYWORD for one in parameters.values())
    known = [*parameters]

    @wraps(function)
    def checked(*arguments: Any, **options: Any) -> Any:
        if not takes_any:
            check_options(name, options, known)
        return function(*arguments, **options)

    # A public function is pickled by its public name.
    checked.__module__ = "tendon_cli"
    checked.__name__ = name
    checked.__qualname__ = name
    return checked
