"""One table made into another, as somebody would who knows how ours are made; the digest is always right."""

import io
import json

from .tables import footer_start, stamped

NUMBERS = [None, 0.0, -0.0, 1.0, -1.0, 5e-324, 1e308, -1e308, float("inf"), float("-inf"), float("nan")]
WORDS = ["", "a", "_b", "$x$", "a\nb", "taut", None]
SAID = [
    None, True, 0, 1, -1, 2**31, 2**63, 10**400, 1e308, float("nan"), float("inf"), "", "case", "designs", "states",
    "load.mass", "motion.elbow_angle", "3 kg", "log", "\0", "a" * 200, [], {}, [[]], [0.0, 3.0], ["load.mass", "case"],
    {"from": 0, "to": 1, "num": 3}, {"from": "1 N", "to": "9 N", "num": 2, "spacing": "log"}, {"index": 0, "of": 2},
]  # fmt: skip


def in_footer(content, chance, mutate):
    """Other bytes in the footer, and a length that fits."""
    start = footer_start(content)
    footer = content[start:-8]
    at = chance.randrange(len(footer))
    piece = footer[at : at + chance.choice((8, 64, 512))]
    footer = footer[:at] + mutate(piece) + footer[at + len(piece) :]
    return content[:start] + footer + len(footer).to_bytes(4, "little") + b"PAR1"


def in_place(content, chance, mutate):
    """Other bytes where they stood: what a page, its header or a number of the footer may say."""
    at = chance.randrange(len(content))
    piece = content[at : at + chance.choice((1, 4, 16, 64))]
    return content[:at] + (mutate(piece) + piece)[: len(piece)] + content[at + len(piece) :]


def regrown(value, chance):
    """A tree in which one twig is another."""
    if isinstance(value, (dict, list)) and value and chance.random() < 0.85:
        grown = value.copy()
        at = chance.choice(list(grown)) if isinstance(grown, dict) else chance.randrange(len(grown))
        if chance.random() < 0.1:
            del grown[at]
        elif chance.random() < 0.1:
            grown |= {chance.choice(list(grown)): grown[at]} if isinstance(grown, dict) else {}
            grown = grown * 2 if isinstance(grown, list) else grown
        else:
            grown[at] = regrown(grown[at], chance)
        return grown
    return chance.choice(SAID)


def with_facts(table, chance, mutate):
    """Another tale of what the table is: its study, its axes, its part."""
    metadata = dict(table.schema.metadata)
    name = chance.choice(sorted(key for key in metadata if key != b"tendon.digest"))
    if chance.random() < 0.2:
        metadata[name] = mutate(metadata[name])
    else:
        metadata[name] = json.dumps(regrown(json.loads(metadata[name]), chance)).encode("utf-8", "replace")
    return table.replace_schema_metadata(metadata)


def with_units(table, chance, mutate):
    """Another unit or meaning of a column."""
    import pyarrow as pa

    at = chance.randrange(table.num_columns)
    field = table.schema.field(at)
    told = dict(field.metadata or {b"unit": b"N"})
    key = chance.choice(sorted(told))
    told[key] = chance.choice([b"", b"N", b"kg", b"parsec", b"\xff", mutate(told[key])])
    return table.cast(pa.schema(table.schema.set(at, field.with_metadata(told)), metadata=table.schema.metadata))


def with_column(table, chance, _mutate):
    """A column of other values, of another type, under another name, twice or not at all."""
    import pyarrow as pa

    at, rows = chance.randrange(table.num_columns), table.num_rows
    field = table.schema.field(at)
    way = chance.randrange(5)
    if way == 0 and table.num_columns > 1:
        return table.drop_columns([field.name])
    if way == 1:
        return table.append_column(field, table.column(at))
    if way == 2:
        kinds = (pa.string(), pa.int32(), pa.float32(), pa.bool_(), pa.null(), pa.list_(pa.float64()), pa.binary())
        return table.set_column(at, field.name, pa.nulls(rows, chance.choice(kinds)))
    if pa.types.is_dictionary(field.type):
        words = pa.array([chance.choice(WORDS) for _ in range(rows)], pa.string())
        return table.set_column(at, field, words.dictionary_encode().cast(field.type))
    if pa.types.is_floating(field.type):
        return table.set_column(at, field, pa.array([chance.choice(NUMBERS) for _ in range(rows)], field.type))
    return table.set_column(at, field, pa.nulls(rows, field.type))


def with_rows(table, chance, _mutate):
    """Rows left out, or twice."""
    import pyarrow as pa

    return chance.choice([table.slice(0, chance.randrange(table.num_rows)), pa.concat_tables([table, table])])


def retold(content, chance, mutate):
    """A sound file that holds other things, or says other things of itself."""
    import pyarrow.parquet as pq

    table = pq.read_table(io.BytesIO(content))
    way = chance.choice((with_facts, with_facts, with_facts, with_units, with_column, with_column, with_rows))
    table = way(table, chance, mutate)
    blank = {**(table.schema.metadata or {}), b"tendon.digest": b"sha256:" + b"0" * 64}
    sink = io.BytesIO()
    pq.write_table(table.replace_schema_metadata(blank), sink, store_schema=True)
    return sink.getvalue()


def forged(content, chance, mutate):
    """Another table with a right digest; of what is no table any more, other bytes."""
    way = chance.choice((retold,) * 6 + (in_footer, in_place))
    try:
        return stamped(way(content, chance, mutate))
    except Exception:  # noqa: BLE001 - whatever cannot be read any more is a case, too
        return stamped(mutate(content))
