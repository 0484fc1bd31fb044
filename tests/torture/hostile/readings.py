"""Hostile readings of load cells."""

from math import exp, pi, sin

from hypothesis import strategies as st

from .edits import EDITS, edited

CSV_TOKENS = [
    b",", b";", b"\t", b'"', b'""', b"'", b"nan", b"inf", b"-inf", b"1e400", b"1e-320", b"-1", b"0", b"1,5", b"1.5",
    b"\r", b"\r\n", b"\n\n", b"\0", b"\xff\xfe", b"\xef\xbb\xbf", b"\xff", b"time", b"direction", b"bend_angle_deg",
    b"bend_angle_rad", b"cell 1", b"cell_2", b"flexion", b"9" * 400, b"," * 300, b"=1+1", b"\xe2\x88\x92", b"1_0",
    b"0x10", b"N", b"[N]", b"1e308", b"-1e308", b"#", b"\xa0", b"TRUE", b"case",
]  # fmt: skip


def good_readings():
    """A table of readings, one in UTF-16, a log, readings at several angles, and readings that name no case."""
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
    return [text.encode() for text in (table, table, angles, plain, plain, log)] + [table.encode("utf-16")]


def friction_files():
    """Mutations of good readings."""
    good = st.sampled_from(good_readings())
    return st.builds(lambda source, edits: (".csv", edited(source, edits, CSV_TOKENS)), good, EDITS)
