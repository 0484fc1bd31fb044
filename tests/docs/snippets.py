"""What pages show, run as a reader would: files written, commands typed, Python called, outputs compared.

A fenced block of a page is one of

    toml, yaml, csv   with a first line `# file: NAME`: the file NAME, as a python block may be besides
    console           lines that start with `$ ` are typed into a shell, what follows is what they print
    python            run in one session for the whole page; a `text` block right after it is what it prints

In an expected output `...` stands for anything. Every page runs in a folder of its own.
"""

import contextlib
import io
import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

FENCE = re.compile(r"^```(\w+)[^\n]*\n(.*?)^```[ \t]*$", re.DOTALL | re.MULTILINE)


@dataclass(frozen=True)
class Block:
    """A fenced block of a page."""

    kind: str
    text: str
    line: int
    follows: bool
    """Whether nothing but white space stands between it and the block before."""


def blocks(page):
    found, end = [], 0
    for match in FENCE.finditer(page):
        between = page[end : match.start()].strip()
        found.append(
            Block(
                match[1],
                match[2],
                page.count("\n", 0, match.start()) + 1,
                bool(found) and not between,
            )
        )
        end = match.end()
    return found


def matches(expected, printed):
    """Whether a text is what was expected, `...` standing for anything and white space at line ends for nothing."""
    pattern = ".*?".join(re.escape(_stripped(part)) for part in expected.split("..."))
    return re.fullmatch(pattern, _stripped(printed), re.DOTALL) is not None


def _stripped(text):
    return re.sub(r"[ \t]+$", "", text, flags=re.MULTILINE).strip("\n")


def run_page(page, folder):
    """Run all blocks of a page; returns what did not come out as shown."""
    session, faults, printed = {"__name__": "__main__"}, [], ""
    found = blocks(page)
    with contextlib.chdir(folder):
        for at, block in enumerate(found):
            name = re.match(r"# file: (\S+)\n", block.text)
            if name:
                # A table has no comments: the name is for the reader.
                content = block.text.partition("\n")[2] if block.kind == "csv" else block.text
                Path(name[1]).write_text(content, encoding="utf-8")
            if block.kind == "console":
                faults += run_console(block)
            elif block.kind == "python":
                printed = run_python(block, session)
                if not (
                    at + 1 < len(found) and found[at + 1].kind == "text" and found[at + 1].follows
                ):
                    printed = ""
            elif block.kind == "text" and block.follows and found[at - 1].kind == "python":
                faults += compared(block.text, printed, f"line {block.line}: Python")
    return faults


def compared(expected, printed, what):
    """What is wrong with a text that was printed: nothing, or one fault."""
    return (
        [] if matches(expected, printed) else [f"{what} printed\n{printed}\ninstead of\n{expected}"]
    )


def run_python(block, session):
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(compile(block.text, f"<page, line {block.line}>", "exec"), session)  # noqa: S102 - our own pages
    return out.getvalue()


def run_console(block):
    """Type each command of a block; a command goes on over lines that end in a backslash."""
    faults = []
    for part in re.split(r"^\$ ", block.text, flags=re.MULTILINE)[1:]:
        command, expected = _split(part)
        environment = os.environ | {
            "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
        }
        environment |= {"COLUMNS": "80", "NO_COLOR": "1"}
        done = subprocess.run(  # noqa: S602 - our own pages
            command,
            shell=True,
            check=False,
            capture_output=True,
            text=True,
            timeout=300,
            env=environment,
        )
        printed = done.stdout + done.stderr
        if not matches(expected, printed):
            faults.append(
                f"line {block.line}: `{command}` (exit {done.returncode}) printed\n{printed}\ninstead of\n{expected}"
            )
    return faults


def _split(part):
    lines = part.split("\n")
    end = 1
    while lines[end - 1].endswith("\\"):
        end += 1
    return "\n".join(lines[:end]), "\n".join(lines[end:])
