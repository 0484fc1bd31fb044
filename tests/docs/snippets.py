"""Run what pages show as a reader would: write files, type commands, call Python, compare outputs.

A fenced block of a page is one of

    toml, yaml, csv   with a first line `# file: NAME`: the file NAME, as a python block may be, too
    console           lines that start with `$ ` are typed into a shell; the rest is what they print
    python            run in one session for the whole page
    text              right after a python block: what this prints

In an expected output `...` stands for anything. Every page runs in a folder of its own.
"""

import contextlib
import io
import os
import re
import shlex
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

from tendon_cli import cli

FENCE = re.compile(r"^```(\w+)[^\n]*\n(.*?)^```[ \t]*$", re.DOTALL | re.MULTILINE)
SHELL_SIGNS = re.compile(r"[|&;<>$*~`#]")
QUOTED = re.compile(r"'[^']*'|\"[^\"]*\"")
FILE_NAME = re.compile(r"# file: (\S+)\n")


@dataclass(frozen=True)
class Block:
    """A fenced block of a page."""

    kind: str
    text: str
    line: int
    follows: bool
    """True if nothing but white space stands between it and the block before."""


def blocks(page):
    """Return the fenced blocks of a page."""
    result = []
    end = 0
    for match in FENCE.finditer(page):
        between = page[end : match.start()].strip()
        line = page.count("\n", 0, match.start()) + 1
        follows = bool(result) and not between
        result.append(Block(match[1], match[2], line, follows))
        end = match.end()
    return result


def matches(expected, printed):
    """Return True if a text is as expected.

    `...` stands for anything, and white space at line ends does not count.
    """
    pattern = ".*?".join(re.escape(_stripped(part)) for part in expected.split("..."))
    return re.fullmatch(pattern, _stripped(printed), re.DOTALL) is not None


def _stripped(text):
    return re.sub(r"[ \t]+$", "", text, flags=re.MULTILINE).strip("\n")


def run_page(page, folder, without=()):
    """Run all blocks of a page. Return everything that did not come out as shown.

    Commands of `without` are not typed.
    """
    session = {"__name__": "__main__"}
    faults = []
    printed = None  # by the Python block before, until another block comes
    with contextlib.chdir(folder):
        for block in blocks(page):
            write_file(block)
            if block.kind == "text" and block.follows and printed is not None:
                faults += compared(block.text, printed, f"line {block.line}: Python")
            printed = None
            if block.kind == "console":
                faults += run_console(block, without)
            elif block.kind == "python":
                printed = run_python(block, session)
    return faults


def write_file(block):
    """Write the file that a block names in its first line, if it names one."""
    name = FILE_NAME.match(block.text)
    if name is None:
        return
    content = block.text
    if block.kind == "csv":
        # A table has no comments: the name is for the reader.
        content = content.partition("\n")[2]
    Path(name[1]).write_text(content, encoding="utf-8")


def compared(expected, printed, source):
    """Return no fault if a printed text is as expected, otherwise one."""
    if matches(expected, printed):
        return []
    return [f"{source} printed\n{printed}\ninstead of\n{expected}"]


def run_python(block, session):
    """Run a block in the session of its page. Return all that it prints."""
    out = io.StringIO()
    code = compile(block.text, f"<page, line {block.line}>", "exec")
    with contextlib.redirect_stdout(out):
        exec(code, session)  # noqa: S102 - our own pages
    return out.getvalue()


def run_console(block, without=()):
    """Type the commands of a block; one goes on over lines that end in a backslash."""
    faults = []
    for part in re.split(r"^\$ ", block.text, flags=re.MULTILINE)[1:]:
        command, expected = _split(part)
        if command in without:
            continue
        code, printed = typed(command)
        source = f"line {block.line}: `{command}` (exit {code})"
        faults += compared(expected, printed, source)
    return faults


def typed(command):
    """Run a command in a shell, or in this process if it is one of tendon alone.

    Return its exit code and all that it prints.
    """
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = {"PATH": path, "COLUMNS": "80", "NO_COLOR": "1"}
    line = command.replace("\\\n", " ")
    is_for_shell = SHELL_SIGNS.search(QUOTED.sub("", line)) is not None
    if is_for_shell or not line.startswith("tendon "):
        ended = subprocess.run(  # noqa: S602 - our own pages
            command,
            shell=True,
            check=False,
            capture_output=True,
            text=True,
            timeout=300,
            env=os.environ | environment,
        )
        return ended.returncode, ended.stdout + ended.stderr
    out = io.StringIO()
    err = io.StringIO()
    with (
        mock.patch.dict(os.environ, environment),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        try:
            cli.main(shlex.split(line)[1:])
        except SystemExit as end:
            return end.code, out.getvalue() + err.getvalue()


def _split(part):
    """Split a command from the output that is shown below it."""
    lines = part.split("\n")
    end = 1
    while lines[end - 1].endswith("\\"):
        end += 1
    return "\n".join(lines[:end]), "\n".join(lines[end:])
