"""What a command says of what it did, as short text: runs, estimates."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tendon_cli.sweep.estimate import Estimate


def run_text(record: dict[str, Any], folder: str, *, up_to_date: bool, note: str | None = None) -> str:
    """The summary of a finished run."""
    designs, states = record["designs"], record["states"]
    head = f"{record['name']}: {_counted(designs, 'design')}, {_counted(states, 'state')}"
    head += ", up to date" if up_to_date else f" in {record['seconds']:.3g} s"
    lines = [head, f"  feasible       {_share(record['feasible'], designs, 'designs')} taut and stable in every state"]
    lines += [f"  slack          {_share(record['slack'], states, 'states')}"]
    lines += [f"  warning        {warning}" for warning in record["warnings"]]
    written = [*dict.fromkeys(entry["path"].split("/")[0] for entry in record["files"]), *record["figures"]]
    lines += [f"  no slack map   {note}"] if note else []
    return "\n".join([*lines, f"  written to     {folder}: {', '.join(written)}"])


def warnings_of(record: dict[str, Any], *, bilateral: bool, sources: dict[str, dict[str, Any]]) -> list[str]:
    """What a reader of the tables has to know first."""
    found = [warning for source in sources.values() for warning in source.get("warnings", ())]
    if record["no_equilibrium"]:
        found.append(
            f"{_share(record['no_equilibrium'], record['states'], 'states')} have no equilibrium: the flexor has "
            "passed the joint's centre (moment arm not positive); their results are null"
        )
    if bilateral and record["slack"]:
        found.append(
            "the bilateral model lets tendons push: tensions in slack states are the paper's, not physics; "
            'slack = "unilateral" gives those of real tendons'
        )
    if record["unstable"]:
        found.append(
            f"{_share(record['unstable'], record['states'], 'states')} are unstable (negative elbow stiffness): the "
            "spool would have to turn back, and friction acts the other way there"
        )
    return found


def estimate_text(estimate: Estimate, name: str, free: int) -> str:
    """The page of `--dry-run`."""
    width = max(len(axis.key) for axis in estimate.axes)
    lines = [f"{name}: nothing is written by --dry-run", "  axes, slowest first"]
    for axis in estimate.axes:
        span = axis.first if axis.count == 1 else f"{axis.first} to {axis.last}"
        lines.append(f"    {axis.key:<{width}}  {axis.count:>8,}  {span}")
    lines.append(f"  designs      {estimate.designs:,}")
    lines.append(f"  states       {estimate.states:,}")
    lines += [f"  rows         {rows:,} in {table}" for table, rows in estimate.rows.items()]
    lines.append(
        f"  disk         {_size(estimate.bytes)} in {_counted(estimate.parts, 'part')}, {_size(free)} are free"
    )
    lines.append(f"  time         about {_duration(estimate.seconds)}")
    lines.append(f"  peak memory  about {_size(estimate.peak_memory)}")
    return "\n".join(lines)


def _counted(count: int, noun: str) -> str:
    return f"{count:,} {noun}" if count == 1 else f"{count:,} {noun}s"


def _share(part: int, whole: int, noun: str) -> str:
    """A count of a whole, with its percentage where that says more."""
    percent = f" ({100 * part / whole:.3g} %)" if 0 < part < whole else ""
    return f"{part:,} of {whole:,} {noun}{percent}"


def _size(count: float) -> str:
    for unit in ("B", "kB", "MB", "GB", "TB"):
        if count < 1000:
            return f"{count:.3g} {unit}"
        count /= 1000
    return f"{count:.4g} PB"


def _duration(seconds: float) -> str:
    for unit, length in (("days", 86400), ("h", 3600), ("min", 60)):
        if seconds >= 2 * length:
            return f"{seconds / length:.2g} {unit}"
    return f"{seconds:.2g} s"
