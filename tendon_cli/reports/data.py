"""What the scripts of a page are given: every name there is, whether the page has it or not."""

from __future__ import annotations

from typing import Any

NO_DATA: dict[str, Any] = {
    "axes": [],
    "quantities": [],
    "states": None,
    "arms": [],
    "table": None,
    "design": None,
    "people": None,
    "start": None,
}
