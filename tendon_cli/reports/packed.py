"""Arrays as a page carries them: deflated, in base64, exact to seven digits or in 65,534 steps of their range."""

from __future__ import annotations

import base64
import zlib
from typing import Any

import numpy as np
import numpy.typing as npt

FEW = 50_000
"""Up to so many numbers keep seven digits."""
_NONE = 65535


def packed(values: npt.ArrayLike) -> dict[str, Any]:
    """A text that the page unpacks to the same numbers, flat; null where not finite."""
    array = np.asarray(values, dtype=np.float64).ravel()
    finite = np.isfinite(array)
    if array.size <= FEW or not finite.any():
        return {"type": "f4", "data": _text(np.where(finite, array, np.nan).astype("<f4"))}
    low, high = float(array[finite].min()), float(array[finite].max())
    step = (high - low) / (_NONE - 1) or 1.0
    steps = np.where(finite, np.rint((np.where(finite, array, low) - low) / step), _NONE)
    return {"type": "u2", "low": low, "step": step, "data": _text(steps.astype("<u2"))}


def packed_classes(values: npt.ArrayLike) -> dict[str, Any]:
    """Small whole numbers."""
    return {"type": "u1", "data": _text(np.asarray(values, dtype=np.uint8).ravel())}


def _text(array: npt.NDArray[Any]) -> str:
    return base64.b64encode(zlib.compress(array.tobytes(), 6)).decode("ascii")
