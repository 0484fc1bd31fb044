"""The compiled code as each kind of processor has it, of which a machine would by itself run one only."""

import ctypes
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from tendon_cli.sweep import native

CODE = native.load(Path(native.__file__).parent)
needs_code = pytest.mark.skipif(CODE is None, reason="tendon was installed without a C compiler")

_NEEDED = {"plain": None, "avx2": "avx2", "avx512": "avx512f"}
"""What a processor has to say of itself before a kind may be called."""


@dataclass(frozen=True)
class Processor:
    """Stands where the library is asked for, and calls the code for one kind of processor."""

    kind: str
    tendon_look: Callable[..., int]
    tendon_rows: Callable[..., None]


def _features() -> set[str]:
    """What the processor has; none where the machine does not say."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return set()
    return {word for line in lines if line.startswith("flags") for word in line.split()}


def _processors(code: ctypes.CDLL | None) -> dict[str, Processor]:
    """Each kind that the compiler has made code for and that this machine can run."""
    features, found = _features(), {}
    for kind, needed in _NEEDED.items():
        names = f"tendon_look_{kind}", f"tendon_rows_{kind}"
        if all(hasattr(code, name) for name in names) and (needed is None or needed in features):
            found[kind] = Processor(kind, *(getattr(code, name) for name in names))
    return found


PROCESSORS = _processors(CODE)


def each_processor() -> list[Processor]:
    """All kinds there are; a test that goes over them must not pass by going over none."""
    assert "plain" in PROCESSORS
    return list(PROCESSORS.values())
