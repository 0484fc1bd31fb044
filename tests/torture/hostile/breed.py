"""One file made into another: any byte changed, as accidents would; another tree of a study; and tables as somebody
would make them who knows how ours are made, with a right digest."""

import hashlib
import io
import json
import tomllib

import pyarrow as pa
import pyarrow.parquet as pq

from .seeds import PLAIN_TOML, TOKENS

NUMBERS = [
    None,
    0.0,
    -0.0,
    1.0,
    -1.0,
    5e-324,
    1e308,
    -1e308,
    float("inf"),
    float("-inf"),
    float("nan"),
]
WORDS = ["", "a", "_b", "$x$", "a\nb", "taut", None]
VALUES = [
    None,
    True,
    0,
    1,
    -1,
    2**31,
    2**63,
    10**400,
    1e308,
    float("nan"),
    float("inf"),
    "",
    "case",
    "designs",
    "states",
    "load.mass",
    "motion.elbow_angle",
    "3 kg",
    "1 kN/m",
    "9**9 mm",
    "1e999 N",
    "45 deg",
    "µm",
    "flexion",
    "bilateral",
    "initial",
    "log",
    "\0",
    "a" * 200,
    [],
    {},
    [[]],
    [0.0, 3.0],
    ["load.mass", "case"],
    {"from": 0, "to": 1, "num": 3},
    {"from": "1 N", "to": "9 N", "num": 2, "spacing": "log"},
    {"from": "0 deg", "to": "90 deg", "num": -1},
    {"index": 0, "of": 2},
]


def breeder(kind, good, mutate=None):
    """What makes one file of a kind into another by chance; `mutate` changes bytes in a way of its own."""

    def breed(content, chance):
        def change(piece):
            return mutate(piece) if mutate else edited(piece, chance, TOKENS[kind])

        if kind == "parquet":
            return forged(content, chance, change) if chance.random() < 0.9 else change(content)
        if kind in ("toml", "yaml") and chance.random() < 0.3:
            tree = regrown(tomllib.loads(PLAIN_TOML.decode()), chance, study_keys())
            return (toml(tree) if kind == "toml" else json.dumps(tree)).encode("utf-8", "replace")
        if chance.random() < 0.5:  # what is bred from faults alone is seldom taken
            content = chance.choice(good)
        return edited(content, chance, TOKENS[kind]) if chance.random() < 0.5 else change(content)

    return breed


def edited(content, chance, tokens):
    """Flips, cuts, copies, and pieces of what such files are made of."""
    content = bytearray(content)
    for _ in range(chance.choice((1, 1, 2, 4))):
        at, length, token = (
            chance.randrange(len(content) + 1),
            chance.randrange(41),
            chance.choice(tokens),
        )
        lines = bytes(content).split(b"\n")
        line = chance.randrange(len(lines))
        match chance.randrange(8):
            case 0 if content:
                content[at % len(content)] = chance.randrange(256)
            case 1:
                del content[at : at + length]
            case 2:
                content[at:at] = content[chance.randrange(len(content) + 1) :][:length]
            case 3:
                content[at:at] = bytes([chance.randrange(256)]) * length
            case 4:
                content[at : at + length] = token
            case 5:
                content[at:at] = token
            case 6:
                key = lines[line].split(b"=")[0].split(b":")[0]
                lines[line] = key + (b"= " if b"=" in lines[line] else b": ") + token
                content = bytearray(b"\n".join(lines))
            case 7:
                lines.insert(chance.randrange(len(lines) + 1), lines[line])
                content = bytearray(b"\n".join(lines))
    return bytes(content)


# --- Trees ----------------------------------------------------------------------------------------


def study_keys():
    """Words that stand in studies as keys."""
    from tendon_cli.studies.study import keys

    return sorted(
        {part for key in keys() for part in key.split(".")} | {"cases", "name", "from", "to", "num"}
    )


def regrown(value, chance, keys=()):
    """A tree in which one twig is another, or has one more."""
    if not (isinstance(value, (dict, list)) and value and chance.random() < 0.85):
        return chance.choice(VALUES)
    grown = value.copy()
    at = chance.choice(list(grown)) if isinstance(grown, dict) else chance.randrange(len(grown))
    dice = chance.random()
    if dice < 0.1:
        del grown[at]
    elif dice < 0.3 and isinstance(grown, dict):
        grown[chance.choice([*grown, *keys])] = chance.choice([grown[at], *VALUES])
    elif dice < 0.2:
        grown = grown * 2
    else:
        grown[at] = regrown(grown[at], chance, keys)
    return grown


def toml(value, *, top=True):
    """A tree as TOML, or as near to it as it can be said."""
    if isinstance(value, dict):
        pairs = [f"{json.dumps(key)} = {toml(inner, top=False)}" for key, inner in value.items()]
        return "\n".join(pairs) if top else "{" + ", ".join(pairs) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(toml(inner, top=False) for inner in value) + "]"
    return repr(value) if isinstance(value, float) else json.dumps(value)


# --- Tables ---------------------------------------------------------------------------------------


def footer_start(content):
    """Where the footer begins."""
    return len(content) - 8 - int.from_bytes(content[-8:-4], "little")


def stamped(content):
    """A file with the right digest; as it is where it has no place for one."""
    from tendon_cli.tables.digest import _LONGEST_FOOTER, _digest_in

    start = max(0, footer_start(content)) if len(content) > 8 else 0
    place = _digest_in(content[start:]) if len(content) < _LONGEST_FOOTER else None
    if place is None:
        return content
    at = start + place
    blank = content[:at] + b"0" * 64 + content[at + 64 :]
    return blank[:at] + hashlib.sha256(blank).hexdigest().encode() + blank[at + 64 :]


def forged(content, chance, change):
    """Another table with a right digest; of what is no table any more, other bytes."""
    way = chance.choice((retold,) * 6 + (in_footer, in_place))
    try:
        return stamped(way(content, chance, change))
    except Exception:  # noqa: BLE001 - whatever cannot be read any more is a case, too
        return stamped(change(content))


def in_footer(content, chance, change):
    """Other bytes in the footer, and a length that fits."""
    start = footer_start(content)
    footer = content[start:-8]
    at = chance.randrange(len(footer))
    piece = footer[at : at + chance.choice((8, 64, 512))]
    footer = footer[:at] + change(piece) + footer[at + len(piece) :]
    return content[:start] + footer + len(footer).to_bytes(4, "little") + b"PAR1"


def in_place(content, chance, change):
    """Other bytes where they stood: what a page, its header or a number of the footer may say."""
    at = chance.randrange(len(content))
    piece = content[at : at + chance.choice((1, 4, 16, 64))]
    return content[:at] + (change(piece) + piece)[: len(piece)] + content[at + len(piece) :]


def retold(content, chance, change):
    """A sound file that holds other things, or says other things of itself."""
    table = pq.read_table(io.BytesIO(content))
    way = chance.choice(
        (with_facts, with_facts, with_facts, with_units, with_column, with_column, with_rows)
    )
    table = way(table, chance, change)
    blank = {**(table.schema.metadata or {}), b"tendon.digest": b"sha256:" + b"0" * 64}
    sink = io.BytesIO()
    pq.write_table(table.replace_schema_metadata(blank), sink, store_schema=True)
    return sink.getvalue()


def with_facts(table, chance, change):
    """Another tale of what the table is: its study, its axes, its part; or none of it."""
    metadata = dict(table.schema.metadata)
    name = chance.choice(sorted(key for key in metadata if key != b"tendon.digest"))
    dice = chance.random()
    if dice < 0.1:
        del metadata[name]
    elif dice < 0.3:
        metadata[name] = change(metadata[name])
    else:
        metadata[name] = json.dumps(regrown(json.loads(metadata[name]), chance)).encode(
            "utf-8", "replace"
        )
    return table.replace_schema_metadata(metadata)


def with_units(table, chance, change):
    """Another unit or meaning of a column."""
    at = chance.randrange(table.num_columns)
    field = table.schema.field(at)
    known = dict(field.metadata or {b"unit": b"N"})
    key = chance.choice(sorted(known))
    known[key] = chance.choice([b"", b"N", b"kg", b"parsec", b"\xff", change(known[key])])
    return table.cast(
        pa.schema(table.schema.set(at, field.with_metadata(known)), metadata=table.schema.metadata)
    )


def with_column(table, chance, _change):
    """A column of other values, of another type, twice or not at all."""
    at, rows = chance.randrange(table.num_columns), table.num_rows
    field, kinds = (
        table.schema.field(at),
        (pa.string(), pa.int32(), pa.float32(), pa.bool_(), pa.list_(pa.float64())),
    )
    match chance.randrange(5):
        case 0 if table.num_columns > 1:
            return table.drop_columns([field.name])
        case 1:
            return table.append_column(field, table.column(at))
        case 2:
            return table.set_column(at, field.name, pa.nulls(rows, chance.choice(kinds)))
    if pa.types.is_dictionary(field.type):
        values = pa.array(
            [chance.choice(WORDS) for _ in range(rows)], pa.string()
        ).dictionary_encode()
        return table.set_column(at, field, values.cast(field.type))
    other = (
        [chance.choice(NUMBERS) for _ in range(rows)]
        if pa.types.is_floating(field.type)
        else [None] * rows
    )
    return table.set_column(at, field, pa.array(other, field.type))


def with_rows(table, chance, _change):
    """Rows left out, or twice."""
    return chance.choice(
        [table.slice(0, chance.randrange(table.num_rows)), pa.concat_tables([table, table])]
    )
