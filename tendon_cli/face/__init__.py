"""The functions of the library, each of which loads what it needs when it is called."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping
    from os import PathLike
    from typing import Any, TypeAlias

    from tendon_cli.answers.result import Answer
    from tendon_cli.engine.results import Run
    from tendon_cli.studies.study import Study

    Name: TypeAlias = str | PathLike[str]
    AnyStudy: TypeAlias = Name | Mapping[str, Any] | Study
    Result: TypeAlias = Name | Run | Answer
    Drawn: TypeAlias = tuple[list[str], list[str], str | None]
