"""Hostile tables: any byte changed, as accidents would, and tables that were made to deceive, with a right digest."""

import hashlib
import io
import json
from pathlib import Path

from hypothesis import strategies as st

from .edits import EDITS, edited

PLAIN = """
[load]
mass = ["0 kg", "3 kg"]
[tendon]
pretension = [60, 120, 240]
[motion]
elbow_angle = ["0 rad", "1 rad", "2 rad"]
"""
WITH_CASES = """
[tendon]
pretension = { from = "60 N", to = "240 N", num = 3, spacing = "log" }
[motion]
direction = "flexion"
elbow_angle = { from = "10 deg", to = "90 deg", num = 2 }
[[cases]]
name = "first"
[[cases]]
name = "second"
sheath.flexor.friction = 0.2
"""


def good_tables(text=PLAIN):
    """The small tables of a study, as bytes."""
    import tempfile

    from tendon_cli.engine.folder import RunFolder
    from tendon_cli.engine.plan import Plan
    from tendon_cli.engine.run import worked_out
    from tendon_cli.engine.sweep import Sweep
    from tendon_cli.studies.load import load_study

    with tempfile.TemporaryDirectory() as place:
        study = Path(place, "study.toml")
        study.write_text(text, "utf-8")
        folder = RunFolder(Path(place, "run"), Sweep(Plan(load_study(study))))
        with folder.locked():
            worked_out(folder, jobs=1)
        return [(folder.path / f"{table}.parquet").read_bytes() for table in ("designs", "states")]


def footer_start(content):
    """Where the footer begins."""
    return len(content) - 8 - int.from_bytes(content[-8:-4], "little")


def stamped(content):
    """A file with the right digest, as somebody would forge it; as it is where it has no place for one."""
    from tendon_cli.tables.digest import _LONGEST_FOOTER, _digest_in

    start = max(0, footer_start(content)) if len(content) > 8 else 0
    place = _digest_in(content[start:]) if len(content) < _LONGEST_FOOTER else None
    if place is None:
        return content
    at = start + place
    blank = content[:at] + b"0" * 64 + content[at + 64 :]
    return blank[:at] + hashlib.sha256(blank).hexdigest().encode() + blank[at + 64 :]


PARQUET_TOKENS = [
    b"PAR1", b"\0" * 8, b"\xff" * 8, b"\x80\x80\x80\x80\x08", b"\xff\xff\xff\xff\x07", b"{}", b"[]", b"null", b'"',
    b"part", b"index", b"states", b"-1", b"\x15\x00", b"\x15\x02", b"\x18\x00", b"tendon.", b"unit", b"1e9",
    b"9" * 30, b"\x19\xfc",
]  # fmt: skip


def with_footer(content, edits):
    """Edits in the footer only, and a length that fits."""
    start = footer_start(content)
    footer = edited(content[start:-8], edits, PARQUET_TOKENS)
    return content[:start] + footer + len(footer).to_bytes(4, "little") + b"PAR1"


def with_same_length(content, edits):
    """Bytes changed in their places: what a page or a footer of the right length may say."""
    changed = bytearray(content)
    for _, place, length, what in edits:
        token = PARQUET_TOKENS[what % len(PARQUET_TOKENS)] if length % 2 else bytes([what % 256])
        at = place % len(changed)
        changed[at : at + len(token)] = token[: len(changed) - at]
    return bytes(changed)


def with_facts(content, edits, tree):
    """A sound file that says other things of itself."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pq.read_table(io.BytesIO(content))
    metadata = dict(table.schema.metadata)
    names = sorted(name for name in metadata if name != b"tendon.digest")
    for kind, place, length, what in edits:
        name = names[place % len(names)]
        if kind < 3:
            metadata.pop(name, None)
        elif kind < 5:
            metadata[name] = json.dumps(tree).encode("utf-8", "replace")
        elif kind == 5:
            metadata[name] = edited(metadata.get(name, b""), [(length % 6, what, length, place)], PARQUET_TOKENS)
        elif kind == 6 and table.num_columns > 1:
            table = table.drop_columns([table.column_names[what % table.num_columns]])
        else:
            at = what % table.num_columns
            kinds = (pa.string(), pa.int32(), pa.float32(), pa.bool_(), pa.null(), pa.list_(pa.float64()))
            values = pa.nulls(table.num_rows, kinds[length % 6])
            table = table.set_column(at, table.column_names[at], values)
    metadata[b"tendon.digest"] = b"sha256:" + b"0" * 64
    sink = io.BytesIO()
    pq.write_table(table.replace_schema_metadata(metadata), sink, store_schema=True)
    return sink.getvalue()


def parquet_files():
    """Tables with any byte changed, as accidents would, and tables that were made to deceive, with a right digest."""
    good, names = st.sampled_from(good_tables()), st.sampled_from(["part", "index", "of", "a", "study"])
    tree = st.recursive(
        st.one_of(st.none(), st.integers(), st.text(max_size=4), st.floats()),
        lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(names, inner, max_size=3)),
        max_leaves=6,
    )  # fmt: skip
    return st.one_of(
        st.builds(lambda content, edits: (".parquet", edited(content, edits, PARQUET_TOKENS)), good, EDITS),
        st.builds(lambda content, edits: (".parquet", stamped(with_footer(content, edits))), good, EDITS),
        st.builds(lambda content, edits: (".parquet", stamped(with_same_length(content, edits))), good, EDITS),
        st.builds(
            lambda content, edits, tree: (".parquet", stamped(with_facts(content, edits, tree))), good, EDITS, tree
        ),
    )
