"""Hostile files by the thousand, in a process of its own so that its memory can be measured.

    python -W error fuzz.py KIND CASES FOLDER

KIND is `study`, `friction` or `parquet`. Prints a JSON object: how many cases were refused or taken, the slowest, the
peak of memory, and each kind of fault that is not a refusal, with a file that brings it about, which stays in FOLDER.
"""

import contextlib
import hashlib
import io
import json
import random
import resource
import signal
import sys
import time
import traceback
from pathlib import Path

from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

CHUNK = 500
LONGEST = 10.0
EDIT = st.tuples(st.integers(0, 7), st.integers(0, 2**20), st.integers(0, 40), st.integers(0, 2**16))
EDITS = st.lists(EDIT, min_size=1, max_size=6)


class TooSlow(BaseException):
    """Not an Exception, so that nothing that is fuzzed can take it for one of its own."""


def edited(content, edits, tokens):
    """Apply edits to bytes: flips, cuts, copies, and pieces of what such files are made of."""
    content = bytearray(content)
    for kind, place, length, what in edits:
        at = place % (len(content) + 1)
        if kind == 0 and content:
            content[at % len(content)] = what % 256
        elif kind == 1:
            del content[at : at + length]
        elif kind == 2:
            content[at:at] = content[what % (len(content) + 1) :][:length]
        elif kind == 3:
            content[at:at] = bytes([what % 256]) * length
        elif kind in (4, 5):
            content[at : at + (length if kind == 4 else 0)] = tokens[what % len(tokens)]
        else:
            lines = bytes(content).split(b"\n")
            line = place % len(lines)
            if kind == 6:
                key = lines[line].split(b"=")[0].split(b":")[0]
                between = b"= " if b"=" in lines[line] else b": "
                lines[line] = key + between + tokens[what % len(tokens)]
            else:
                lines.insert(what % (len(lines) + 1), lines[line])
            content = bytearray(b"\n".join(lines))
    return bytes(content)


# --- Studies ---------------------------------------------------------------------------------------------------------

STUDY_TOKENS = [
    b"nan", b"-inf", b"1e400", b"9**9**9 m", b'"9**9**9 m"', b'"1e-400 N"', b"[[cases]]", b"[[[", b"]]", b"{", b"}",
    b"{{", b'"""', b"'''", b"\0", b"\xff\xfe", b"\xef\xbb\xbf", b"\t", b"\r", b"# ", b"&a ", b"*a", b"<<: *a",
    b"!!python/object:os.system ", b"--- ", b"...", b"? ", b"- ", b"|", b">", b"true", b"null", b"~", b"2020-01-01",
    b"0x10", b"1_0", b'"1 parsec"', b'"-1 N"', b'"0 kg"', b"[]", b'["1 N", "2 N"]',
    b'{ from = "0 N", to = "1 N", num = 3 }', b"{ from = 0, to = 1, num = 99999999 }",
    b'{ from = 1, to = 1e300, num = 5, spacing = "log" }', b"a.b.c.d.e.f.g = 1", b"model.slack",
    b"sheath.flexor.friction", b"path = '/dev/zero'", b'friction_from = "study"', b"\xc2\xb5", b"\xe2\x80\xae",
    b"9" * 400, b"1" * 4301, b"[" * 40, b"a." * 20, b"num", b"direction", b"elbow_angle", b'"180 deg"', b"1e308",
    b"-0.0", b'"case"', b"name", b"\\u0000", b'"\\ud800"',
]  # fmt: skip


PLAIN_TOML = b"""name = "a"
[load]
mass = ["0 kg", "3 kg"]
[sheath.flexor]
friction = 0.1
[[cases]]
name = "x"
arm.b1 = "160 mm"
"""
PLAIN_YAML = b"""name: a
load:
  mass: [0 kg, 3 kg]
cases:
  - name: x
    arm: {b1: 160 mm}
motion:
  elbow_angle: {from: 0 deg, to: 90 deg, num: 4}
"""


def study_trees():
    """Documents of any shape, of which most keys are keys of a study."""
    from tendon_cli.study.study import keys

    names = sorted(
        {part for key in keys() for part in key.split(".")} | {"cases", "name", "from", "to", "num", "flexor"}
    )
    name = st.one_of(st.sampled_from(names), st.sampled_from(names), st.text(max_size=4))
    quantity = st.builds(
        "{} {}".format,
        st.one_of(st.integers(-10, 1000), st.floats(), st.sampled_from(["1e999", "9**9", "0x1", ".5"])),
        st.sampled_from(["mm", "m", "N", "kN/m", "GPa", "kg", "deg", "rad", "N m", "", "mm mm", "µm"]),
    )
    leaf = st.one_of(
        st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=8), quantity, quantity,
        st.fixed_dictionaries({"from": quantity, "to": quantity, "num": st.integers(-1, 9)}),
        st.sampled_from(["flexion", "extension", "unilateral", "bilateral", "initial", "states", "log"]),
    )  # fmt: skip
    tree = st.recursive(
        leaf,
        lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(name, inner, max_size=5)),
        max_leaves=12,
    )
    table = st.dictionaries(name, st.one_of(leaf, leaf, tree), max_size=6)
    roots = sorted({key.partition(".")[0] for key in keys()} | {"cases", "motion", "model", "output", "name"})
    return st.dictionaries(st.sampled_from(roots), st.one_of(table, table, tree), max_size=5)


def toml(value, *, top=True):
    """A tree as TOML, or as near to it as it can be said."""
    if isinstance(value, dict):
        pairs = [f"{json.dumps(key)} = {toml(inner, top=False)}" for key, inner in value.items()]
        return "\n".join(pairs) if top else "{" + ", ".join(pairs) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(toml(inner, top=False) for inner in value) + "]"
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value)


def study_files():
    """Mutations of the starters and random trees, as TOML and YAML."""
    from tendon_cli.study.starter import starter

    seeds = [(suffix, starter(Path("a" + suffix)).encode()) for suffix in (".toml", ".yaml")]
    uncommented = [
        (suffix, b"\n".join(line.removeprefix(b"# ") if b"=" in line or b": " in line else line for line in lines))
        for suffix, lines in ((suffix, text.split(b"\n")) for suffix, text in seeds)
    ]
    plain = [(".toml", PLAIN_TOML), (".yaml", PLAIN_YAML)]
    mutated = st.builds(
        lambda source, edits: (source[0], edited(source[1], edits, STUDY_TOKENS)),
        st.sampled_from(seeds + plain + plain + uncommented),
        EDITS,
    )
    trees = st.builds(
        lambda tree, suffix: (
            suffix,
            (toml(tree) if suffix == ".toml" else json.dumps(tree)).encode("utf-8", "replace"),
        ),
        study_trees(),
        st.sampled_from([".toml", ".yaml"]),
    )
    return st.one_of(mutated, trees)


def try_study(file):
    """What a command does with a study before it computes anything, and one state."""
    from tendon_cli.state_page import state_page
    from tendon_cli.study.load import load_study
    from tendon_cli.sweep.plan import Plan

    study = load_study(file)
    plan = Plan(study)
    json.dumps(study.record())
    _ = plan.designs, plan.states, plan.parts, study.hash, study.document()
    json.dumps(state_page(study, study.cases[0].name if study.cases else None).record())


# --- Friction readings -----------------------------------------------------------------------------------------------

CSV_TOKENS = [
    b",", b";", b"\t", b'"', b'""', b"'", b"nan", b"inf", b"-inf", b"1e400", b"1e-320", b"-1", b"0", b"1,5", b"1.5",
    b"\r", b"\r\n", b"\n\n", b"\0", b"\xff\xfe", b"\xef\xbb\xbf", b"\xff", b"time", b"direction", b"bend_angle_deg",
    b"bend_angle_rad", b"cell 1", b"cell_2", b"flexion", b"9" * 400, b"," * 300, b"=1+1", b"\xe2\x88\x92", b"1_0",
    b"0x10", b"N", b"[N]", b"1e308", b"-1e308", b"#", b"\xa0", b"TRUE", b"case",
]  # fmt: skip


def friction_files():
    """Mutations of a table of readings, of logs, and of readings at several angles."""
    from math import exp, pi, sin

    strokes = [("pull", 1.2), ("release", 0.8)]
    table = "case,cell 1,cell 2\n"
    table += "".join(f"{case},{force * ratio:.3f},{force}\n" for case, ratio in strokes for force in (20, 40, 60))
    angles = "bend_angle_deg;cell 1;cell 2\n"
    for angle, sign in [(angle, sign) for angle in (45, 90, 180) for sign in (1, -1)]:
        angles += f"{angle};{50 * exp(sign * 0.1 * angle * pi / 180):.3f};50,0\n".replace(".", ",")
    log = "time,direction,cell 1,cell 2\n"
    for step in range(120):
        force, (case, ratio) = 40 + 20 * sin(step / 6.4), strokes[step // 20 % 2]
        log += f"{step / 10},{case},{force * ratio:.4f},{force:.4f}\n"
    plain = "cell 1\tcell 2\n1.2\t1\n2.4\t2\n1\t1.2\n2\t2.4\n"
    seeds = [text.encode() for text in (table, table, angles, plain, plain, log)] + [table.encode("utf-16")]
    return st.builds(lambda source, edits: (".csv", edited(source, edits, CSV_TOKENS)), st.sampled_from(seeds), EDITS)


def try_friction(file):
    """Fit, and say it in both ways."""
    from tendon_cli import friction

    header = file.read_bytes()[:200]
    fit = friction.fit_file(file, bend_angle=None if b"bend" in header else "144 deg")
    json.dumps(friction.as_json(fit))
    friction.summary_lines(fit)


# --- Tables ----------------------------------------------------------------------------------------------------------


TABLE_STUDY = """
[load]
mass = ["0 kg", "3 kg"]
[tendon]
pretension = [60, 120, 240]
[motion]
elbow_angle = [0, 1, 2]
"""


def good_tables():
    """Small tables of ours, as bytes."""
    import tempfile
    import threading

    from tendon_cli.study.load import load_study
    from tendon_cli.sweep.plan import Plan
    from tendon_cli.sweep.run import run
    from tendon_cli.sweep.run_folder import RunFolder

    with tempfile.TemporaryDirectory() as place:
        study = Path(place, "study.toml")
        study.write_text(TABLE_STUDY, "utf-8")
        folder = RunFolder(Path(place, "run"), Plan(load_study(study)))
        with folder.locked():
            run(folder, jobs=1, stop=threading.Event(), progress=lambda _done, _all: None)
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


def try_parquet(file):
    """What `plot` reads of a table before it draws."""
    from tendon_cli.figures.product import product_of
    from tendon_cli.tables.read import open_table

    table = open_table(file)
    _ = table.facts, table.rows, table.schema
    table.read()
    product_of(table)


# --- The loop --------------------------------------------------------------------------------------------------------

KINDS = {
    "study": (study_files, try_study),
    "friction": (friction_files, try_friction),
    "parquet": (parquet_files, try_parquet),
}


def peak():
    """Most memory that was ever in use, in MB; of this process alone, where getrusage counts its parent's."""
    try:
        status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text("utf-8").splitlines())
        return int(status["VmHWM"].split()[0]) / 1024
    except (OSError, KeyError):
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


class Tally:
    """What became of the cases."""

    def __init__(self, folder, attempt):
        self.folder, self.attempt = folder, attempt
        self.cases, self.taken, self.refused, self.slowest = 0, 0, {}, 0.0
        self.faults = {}

    def meet(self, suffix, content):
        """Try one file; whatever it ends in is counted."""
        from tendon_cli.errors import TendonError

        self.cases += 1
        file = self.folder / f"case{suffix}"
        file.write_bytes(content)
        began = time.perf_counter()
        signal.setitimer(signal.ITIMER_REAL, LONGEST)
        try:
            self.attempt(file)
            self.taken += 1
        except TendonError as error:
            if error.exit not in (2, 3):
                self.fault(error, suffix, content)
            self.refused[error.kind] = self.refused.get(error.kind, 0) + 1
        except (Exception, TooSlow) as error:  # noqa: BLE001 - just what is looked for
            self.fault(error, suffix, content)
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
        self.slowest = max(self.slowest, time.perf_counter() - began)

    def fault(self, error, suffix, content):
        """Keep the shortest file of each kind of fault."""
        ours = [frame for frame in traceback.extract_tb(error.__traceback__) if "tendon_cli" in frame.filename]
        where = f"{Path(ours[-1].filename).name}:{ours[-1].name}" if ours else "?"
        name = f"{type(error).__name__} in {where}"
        kept = self.faults.get(name)
        if kept is None or len(content) < kept["length"]:
            file = self.folder / f"fault-{hashlib.sha256(name.encode()).hexdigest()[:8]}{suffix}"
            file.write_bytes(content)
            count = kept["count"] if kept else 0
            self.faults[name] = {"count": count, "length": len(content), "file": str(file), "says": str(error)[:300]}
        self.faults[name]["count"] += 1

    def record(self):
        """All of it, as one object."""
        return {
            "cases": self.cases,
            "taken": self.taken,
            "refused": self.refused,
            "slowest": round(self.slowest, 3),
            "peak_megabytes": peak(),
            "faults": self.faults,
        }


def too_slow(_number, _frame):
    """The alarm."""
    raise TooSlow(f"longer than {LONGEST} s")


def main():
    """All cases, in chunks of so many that the generator's own memory stays small."""
    kind, cases, folder = sys.argv[1], int(sys.argv[2]), Path(sys.argv[3])
    make, attempt = KINDS[kind]
    tally, files = Tally(folder, attempt), make()
    signal.signal(signal.SIGALRM, too_slow)
    chunk = 0
    while tally.cases < cases:
        chunk += 1

        @seed(chunk)
        @settings(
            max_examples=min(CHUNK, cases - tally.cases), database=None, deadline=None, phases=[Phase.generate],
            suppress_health_check=list(HealthCheck),
        )  # fmt: skip
        @given(files)
        def one(case):
            tally.meet(*case)

        one()
    (folder / "tally.json").write_text(json.dumps(tally.record(), indent=1), "utf-8")


if __name__ == "__main__":
    random.seed(0)
    with contextlib.redirect_stdout(sys.stderr):
        main()
