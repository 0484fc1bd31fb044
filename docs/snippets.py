"""Run what pages show as a reader would: write files, type commands, call Python.

A fenced block of a page is one of

    toml, csv         with a first line `# file: NAME`: the file NAME; toml is a study, and is read
    console           lines that start with `$ ` are typed into a shell; the rest is what they print
    python            run in one session for the whole page
    text              right after a python block: what this prints

In an expected output `...` stands for anything. Every page runs in a folder of its own.
"""

import contextlib
import io
import math
import os
import re
import shlex
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

import tendon_cli
from tendon_cli.commands import cli

FENCE = re.compile(r"^```(\w+)[^\n]*\n(.*?)^```[ \t]*$", re.DOTALL | re.MULTILINE)
COMMAND = re.compile(r"^\$ ((?:[^\n]*\\\n)*[^\n]*)\n((?:(?!\$ )[^\n]*\n)*)", re.MULTILINE)
"""A command, which goes on over lines that end in a backslash, and what it prints."""
SHELL_SIGNS = re.compile(r"[|&;<>$*~`#]")
QUOTED = re.compile(r"'[^']*'|\"[^\"]*\"")
FILE_NAME = re.compile(r"# file: (\S+)\n")


@dataclass(frozen=True)
class Block:
    """A fenced block of a page."""

    kind: str
    text: str
    start: int
    """Place of the text in the page."""
    line: int
    follows: bool
    """True if nothing but white space stands between it and the block before."""


@dataclass(frozen=True)
class Output:
    """An output that a page shows, and what was printed."""

    source: str
    expected: str
    printed: str
    start: int
    """Place of the expected text in the page."""

    @property
    def is_as_expected(self) -> bool:
        """True if it was printed; white space at line ends does not count."""
        return matches(self.expected, self.printed)


def blocks(page: str) -> list[Block]:
    """Return the fenced blocks of a page."""
    result: list[Block] = []
    end = 0
    for match in FENCE.finditer(page):
        between = page[end : match.start()].strip()
        line = page.count("\n", 0, match.start()) + 1
        follows = bool(result) and not between
        result.append(Block(match[1], match[2], match.start(2), line, follows))
        end = match.end()
    return result


def matches(expected: str, printed: str) -> bool:
    """Return True if a text is as expected, where `...` stands for anything."""
    pattern = ".*?".join(re.escape(_stripped(part)) for part in expected.split("..."))
    return re.fullmatch(pattern, _stripped(printed), re.DOTALL) is not None


def _stripped(text: str) -> str:
    return re.sub(r"[ \t]+$", "", text, flags=re.MULTILINE).strip("\n")


def outputs(page: str, folder: Path) -> Iterator[Output]:
    """Run all blocks of a page in a folder, and yield each output that it shows."""
    session: dict[str, Any] = {"__name__": "__main__"}
    printed = None  # by the Python block before, until another block comes
    for block in blocks(page):
        with contextlib.chdir(folder):
            write_file(block)
            if block.kind == "toml":
                read_study(block)
            if block.kind == "text" and block.follows and printed is not None:
                source = f"line {block.line}: Python"
                yield Output(source, block.text, printed, block.start)
            printed = None
            if block.kind == "python":
                printed = run_python(block, session)
            elif block.kind == "console":
                yield from run_console(block)


def run_page(page: str, folder: Path) -> list[str]:
    """Run all blocks of a page. Return everything that did not come out as shown."""
    return [
        f"{output.source} printed\n{output.printed}\ninstead of\n{output.expected}"
        for output in outputs(page, folder)
        if not output.is_as_expected
    ]


def write_file(block: Block) -> None:
    """Write the file that a block names in its first line, if it names one."""
    name = FILE_NAME.match(block.text)
    if name is None:
        return
    content = block.text
    if block.kind == "csv":
        # A table has no comments: the name is for the reader.
        content = content.partition("\n")[2]
    Path(name[1]).write_text(content, encoding="utf-8")


def read_study(block: Block) -> None:
    """Read the study that a block is; a fault of it is raised."""
    name = FILE_NAME.match(block.text)
    tendon_cli.study(name[1] if name else tomllib.loads(block.text))


def run_python(block: Block, session: dict[str, Any]) -> str:
    """Run a block in the session of its page. Return all that it prints."""
    out = io.StringIO()
    code = compile(block.text, f"<page, line {block.line}>", "exec")
    with contextlib.redirect_stdout(out):
        exec(code, session)  # noqa: S102 - our own pages
    return out.getvalue()


def run_console(block: Block) -> Iterator[Output]:
    """Type the commands of a block, and yield what each prints."""
    for match in COMMAND.finditer(block.text):
        code, printed = typed(match[1])
        source = f"line {block.line}: `{match[1]}` (exit {code})"
        yield Output(source, match[2], printed, block.start + match.start(2))


def typed(command: str) -> tuple[Any, str]:
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
        mock.patch("tendon_cli.terminal._LONGEST_SILENCE", math.inf),  # on a busy machine, too
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        try:
            cli.main(shlex.split(line)[1:])
        except SystemExit as end:
            return end.code, out.getvalue() + err.getvalue()
    return 0, out.getvalue() + err.getvalue()
