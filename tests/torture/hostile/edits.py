"""Edits of bytes, by which one file becomes many hostile ones."""

from hypothesis import strategies as st

EDIT = st.tuples(st.integers(0, 7), st.integers(0, 2**20), st.integers(0, 40), st.integers(0, 2**16))
EDITS = st.lists(EDIT, min_size=1, max_size=6)


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
