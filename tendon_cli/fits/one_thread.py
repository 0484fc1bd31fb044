"""One thread for linear algebra on small matrices.

OpenBLAS divides matrices of a few hundred rows among all cores, which on a busy machine takes five
to ten times as long as one core alone.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any


@contextmanager
def one_thread() -> Iterator[None]:
    """Let the OpenBLAS of NumPy and SciPy use one thread, and then as many as before.

    Other libraries are left as they are.
    """
    limited = []
    for get, put in _openblas():
        limited.append((put, get()))
        put(1)
    try:
        yield
    finally:
        for put, threads in limited:
            put(threads)


def _openblas() -> Iterator[tuple[Any, Any]]:
    """Yield the functions that give and set the number of threads, for each library."""
    import numpy as np
    import scipy

    for module in (np, scipy):
        folder = Path(str(module.__file__)).parent
        for file in folder.with_name(f"{folder.name}.libs").glob("*openblas*"):
            library = ctypes.CDLL(str(file))
            for ending in ("64_", ""):
                name = f"scipy_openblas_%s_num_threads{ending}"
                if hasattr(library, name % "set"):
                    yield getattr(library, name % "get"), getattr(library, name % "set")
