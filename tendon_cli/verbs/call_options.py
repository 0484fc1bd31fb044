"""Arguments of the library's functions: an unknown one, or one of a wrong type, is refused."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import wraps
from numbers import Integral, Real
from typing import Any

from tendon_cli.errors import UsageError
from tendon_cli.units import described


def _is_truth(value: Any) -> bool:
    return type(value).__name__ in ("bool", "bool_")


def _are_texts(value: Any) -> bool:
    is_listed = isinstance(value, Iterable) and not isinstance(value, (str, bytes))
    return is_listed and all(isinstance(item, str) for item in value)


_KINDS: dict[str, tuple[Callable[[Any], bool], str]] = {
    "None": (lambda value: value is None, "None"),
    "bool": (_is_truth, "True or False"),
    "int": (lambda value: isinstance(value, Integral) and not _is_truth(value), "a whole number"),
    "float": (lambda value: isinstance(value, Real) and not _is_truth(value), "a number"),
    "str": (lambda value: isinstance(value, str), "a text"),
    "Iterable[str]": (_are_texts, "a list of texts"),
    "Sequence[str]": (_are_texts, "a list of texts"),
    "Mapping[str, str]": (lambda value: isinstance(value, Mapping), "a dictionary"),
    "Callable": (callable, "a function"),
    "Event": (lambda value: hasattr(value, "is_set"), "a threading.Event"),
}
"""For the annotation of an argument, if it fits, and what is expected."""


def check_types(function: str, given: Mapping[str, Any], annotations: Mapping[str, Any]) -> None:
    """Raise UsageError for an argument of another type than its annotation says.

    Paths, studies and results are judged where they are read.

    Args:
        function: Public name of the function.
        given: Arguments by name.
        annotations: Annotations of all arguments, as texts or references.
    """
    for name, value in given.items():
        annotation = annotations.get(name, "")
        text = getattr(annotation, "__forward_arg__", annotation)
        parts = str(text).split(" | ")
        kinds = [_KINDS.get(part.partition("[[")[0] or part) for part in parts]
        known = [kind for kind in kinds if kind is not None]
        if len(known) < len(kinds) or any(fits(value) for fits, _ in known):
            continue
        expected = " or ".join(words for _, words in known)
        problem = f"{name} = {described(value)} is not possible, expected {expected}"
        raise UsageError(problem, where=f"{function}()")


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

    The result refuses arguments that the function does not have, or whose types are wrong, by a
    `UsageError`. A function that takes any option, such as `plot`, checks them by itself.
    """
    signature = inspect.signature(function)
    parameters = signature.parameters
    takes_any = any(one.kind is one.VAR_KEYWORD for one in parameters.values())
    known = [*parameters]

    @wraps(function)
    def checked(*arguments: Any, **options: Any) -> Any:
        if not takes_any:
            check_options(name, options, known)
        try:
            bound = signature.bind(*arguments, **options)
        except TypeError as error:
            raise UsageError(str(error), where=f"{name}()") from None
        check_types(name, bound.arguments, function.__annotations__)
        return function(*arguments, **options)

    # A public function is pickled by its public name.
    checked.__module__ = "tendon_cli"
    checked.__name__ = name
    checked.__qualname__ = name
    return checked
