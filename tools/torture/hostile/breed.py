"""Make one file into another.

Bytes are changed as accidents would, studies become other trees, and tables are made as somebody
would make them who knows how ours are made, with a right digest.
"""

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
    """Return a function that makes a file of a kind into another by chance.

    Args:
        kind: Ending of the files.
        good: Contents of good files.
        mutate: Function that changes bytes; they are edited by chance if it is None.
    """

    def breed(content, rng):
        def change(piece):
            return edited(piece, rng, TOKENS[kind]) if mutate is None else mutate(piece)

        if kind == "parquet":
            return forged(content, rng, change) if rng.random() < 0.9 else change(content)
        if kind in ("toml", "yaml") and rng.random() < 0.3:
            tree = regrown(tomllib.loads(PLAIN_TOML.decode()), rng, study_keys())
            text = toml(tree) if kind == "toml" else json.dumps(tree)
            return text.encode("utf-8", "replace")
        if rng.random() < 0.5:  # what is bred from faults alone is seldom taken
            content = rng.choice(good)
        return edited(content, rng, TOKENS[kind]) if rng.random() < 0.5 else change(content)

    return breed


def edited(content, rng, tokens):
    """Flip, cut and copy bytes, and put in pieces that such files are made of."""
    content = bytearray(content)
    for _ in range(rng.choice((1, 1, 2, 4))):
        start = rng.randrange(len(content) + 1)
        length = rng.randrange(41)
        token = rng.choice(tokens)
        lines = bytes(content).split(b"\n")
        number = rng.randrange(len(lines))
        line = lines[number]
        match rng.randrange(8):
            case 0 if content:
                content[start % len(content)] = rng.randrange(256)
            case 1:
                del content[start : start + length]
            case 2:
                source = rng.randrange(len(content) + 1)
                content[start:start] = content[source : source + length]
            case 3:
                content[start:start] = bytes([rng.randrange(256)]) * length
            case 4:
                content[start : start + length] = token
            case 5:
                content[start:start] = token
            case 6:
                key = line.split(b"=")[0].split(b":")[0]
                lines[number] = key + (b"= " if b"=" in line else b": ") + token
                content = bytearray(b"\n".join(lines))
            case 7:
                lines.insert(rng.randrange(len(lines) + 1), line)
                content = bytearray(b"\n".join(lines))
    return bytes(content)


# --- Trees ----------------------------------------------------------------------------------------


def study_keys():
    """Return the words that stand in studies as keys."""
    from tendon_cli.studies.study import keys

    parts = {part for key in keys() for part in key.split(".")}
    return sorted(parts | {"cases", "name", "from", "to", "num"})


def regrown(value, rng, keys=()):
    """Return a tree in which one twig is another, is missing, or has one more."""
    is_branch = isinstance(value, (dict, list)) and len(value) > 0
    if not is_branch or rng.random() >= 0.85:
        return rng.choice(VALUES)
    grown = value.copy()
    is_table = isinstance(grown, dict)
    place = rng.choice(list(grown)) if is_table else rng.randrange(len(grown))
    dice = rng.random()
    if dice < 0.1:
        del grown[place]
    elif dice < 0.3 and is_table:
        twig = rng.choice([grown[place], *VALUES])
        key = rng.choice([*grown, *keys])
        grown[key] = twig
    elif dice < 0.2:
        grown = grown * 2
    else:
        grown[place] = regrown(grown[place], rng, keys)
    return grown


def toml(value, *, top=True):
    """Return a tree as TOML, or as something near to it if TOML cannot express it."""
    if isinstance(value, dict):
        pairs = [f"{json.dumps(key)} = {toml(inner, top=False)}" for key, inner in value.items()]
        return "\n".join(pairs) if top else "{" + ", ".join(pairs) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(toml(inner, top=False) for inner in value) + "]"
    return repr(value) if isinstance(value, float) else json.dumps(value)


# --- Tables ---------------------------------------------------------------------------------------


def footer_start(content):
    """Return the place at which the footer of a table begins."""
    return len(content) - 8 - int.from_bytes(content[-8:-4], "little")


def stamped(content):
    """Return a file with the right digest, or as it is if it has no place for one."""
    from tendon_cli.tables.digest import digest_place
    from tendon_cli.tables.footer import _LONGEST

    start = max(0, footer_start(content)) if len(content) > 8 else 0
    place = digest_place(content[start:]) if len(content) < _LONGEST else None
    if place is None:
        return content
    before = content[: start + place]
    after = content[start + place + 64 :]
    digest = hashlib.sha256(before + b"0" * 64 + after).hexdigest()
    return before + digest.encode() + after


def forged(content, rng, change):
    """Return another table with a right digest; other bytes if the content is no table any more."""
    forge = rng.choice((with_other_contents,) * 6 + (in_footer, in_place))
    try:
        return stamped(forge(content, rng, change))
    except Exception:  # noqa: BLE001 - whatever cannot be read any more is a case, too
        return stamped(change(content))


def in_footer(content, rng, change):
    """Return a file with other bytes in the footer, and a length that fits."""
    start = footer_start(content)
    footer = content[start:-8]
    place = rng.randrange(len(footer))
    piece = footer[place : place + rng.choice((8, 64, 512))]
    footer = footer[:place] + change(piece) + footer[place + len(piece) :]
    return content[:start] + footer + len(footer).to_bytes(4, "little") + b"PAR1"


def in_place(content, rng, change):
    """Return a file of the same length with other bytes in a page, its header or the footer."""
    place = rng.randrange(len(content))
    piece = content[place : place + rng.choice((1, 4, 16, 64))]
    changed = (change(piece) + piece)[: len(piece)]
    return content[:place] + changed + content[place + len(piece) :]


def with_other_contents(content, rng, change):
    """Return a sound file with other facts, units, columns or rows."""
    table = pq.read_table(io.BytesIO(content))
    alter = rng.choice((with_facts,) * 3 + (with_units, with_column, with_column, with_rows))
    table = alter(table, rng, change)
    blank = {**(table.schema.metadata or {}), b"tendon.digest": b"sha256:" + b"0" * 64}
    sink = io.BytesIO()
    pq.write_table(table.replace_schema_metadata(blank), sink, store_schema=True)
    return sink.getvalue()


def with_facts(table, rng, change):
    """Change a fact about the table, such as its study, its axes or its part, or remove it."""
    metadata = dict(table.schema.metadata)
    name = rng.choice(sorted(key for key in metadata if key != b"tendon.digest"))
    dice = rng.random()
    if dice < 0.1:
        del metadata[name]
    elif dice < 0.3:
        metadata[name] = change(metadata[name])
    else:
        tree = regrown(json.loads(metadata[name]), rng)
        metadata[name] = json.dumps(tree).encode("utf-8", "replace")
    return table.replace_schema_metadata(metadata)


def with_units(table, rng, change):
    """Change the unit or the meaning of a column."""
    index = rng.randrange(table.num_columns)
    field = table.schema.field(index)
    known = dict(field.metadata or {b"unit": b"N"})
    key = rng.choice(sorted(known))
    known[key] = rng.choice([b"", b"N", b"kg", b"parsec", b"\xff", change(known[key])])
    fields = table.schema.set(index, field.with_metadata(known))
    return table.cast(pa.schema(fields, metadata=table.schema.metadata))


def with_column(table, rng, _change):
    """Give a column other values or another type, repeat it, or leave it out."""
    index = rng.randrange(table.num_columns)
    rows = table.num_rows
    field = table.schema.field(index)
    match rng.randrange(5):
        case 0 if table.num_columns > 1:
            return table.drop_columns([field.name])
        case 1:
            return table.append_column(field, table.column(index))
        case 2:
            types = (pa.string(), pa.int32(), pa.float32(), pa.bool_(), pa.list_(pa.float64()))
            return table.set_column(index, field.name, pa.nulls(rows, rng.choice(types)))
    if pa.types.is_dictionary(field.type):
        words = [rng.choice(WORDS) for _ in range(rows)]
        values = pa.array(words, pa.string()).dictionary_encode()
        return table.set_column(index, field, values.cast(field.type))
    numbers = [None] * rows
    if pa.types.is_floating(field.type):
        numbers = [rng.choice(NUMBERS) for _ in range(rows)]
    return table.set_column(index, field, pa.array(numbers, field.type))


def with_rows(table, rng, _change):
    """Leave rows out, or repeat them."""
    fewer = table.slice(0, rng.randrange(table.num_rows))
    twice = pa.concat_tables([table, table])
    return rng.choice([fewer, twice])
