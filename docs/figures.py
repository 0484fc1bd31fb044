"""Make the figures of the pages: `python docs/figures.py [PAGE]`.

Above an image, or a link to a page of HTML, stands how it is made,
`<!-- made by: COMMAND -> FILE -->`: a command for a shell, in a folder with the files of the page
(blocks that begin with `# file: NAME`) and `configs`, and the file that it leaves. `make docs`
makes those of all pages; pages of HTML go to `pages`, from where Sphinx copies them beside its own.
The figure of the README is kept in the repository, made by `python docs/figures.py README.md`.
"""

from __future__ import annotations

import contextlib
import io
import multiprocessing
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from tendon_cli.commands import cli
from tendon_cli.errors import EXIT_NEGATIVE

DOCS = Path(__file__).parent
IMPORTED = [
    "tendon_cli.commands.cli",
    "tendon_cli.answers.record",
    "tendon_cli.figures.draw",
    "tendon_cli.figures.answer_figures",
    "tendon_cli.fits.friction",
    "matplotlib.backends.backend_agg",
    "pandas",
    "pyarrow.parquet",
    "scipy.optimize",
]
"""Modules that nearly every command imports."""
_MADE_BY = r"<!-- made by: ((?:(?!-->).)+) -> (\S+) -->\n+"
RECIPE = re.compile(_MADE_BY + r"!\[[^\]]*\]\((\S+?)\)", re.DOTALL)
PAGE = re.compile(_MADE_BY + r'<a href="(\S+?)">', re.DOTALL)
FILE = re.compile(r"^```\w+\n# file: (\S+)\n(.*?)^```", re.DOTALL | re.MULTILINE)


Files = tuple[tuple[str, str], ...]
"""Names of files with their contents."""
Images = list[tuple[str, Path]]
"""Files that a command leaves, each with the image or page that it becomes."""


def make_figures(*pages: Path) -> list[Path]:
    """Make all figures of pages, several at a time; a command that figures share is run once.

    Returns:
        Their files.

    Raises:
        CalledProcessError: A command failed.
    """
    wanted: dict[tuple[str, Files], Images] = {}
    for page in pages:
        text = page.read_text(encoding="utf-8")
        files = tuple(FILE.findall(text))
        linked = [(command, made, f"pages/{link}") for command, made, link in PAGE.findall(text)]
        for command, result, image in [*RECIPE.findall(text), *linked]:
            reads_page = any(name in command for name, _ in files)
            run = command, files if reads_page else ()
            wanted.setdefault(run, []).append((result, page.parent / image))
    # Each command has a process of its own, in which tendon is imported already.
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(IMPORTED)
    with context.Pool(os.cpu_count(), maxtasksperchild=1) as pool:
        made: list[Path] = []
        for images in pool.imap_unordered(_make, wanted.items()):
            sys.stdout.write("".join(f"{image}\n" for image in images))
            sys.stdout.flush()
            made += images
    return made


def _make(wanted: tuple[tuple[str, Files], Images]) -> list[Path]:
    """Run a command in a folder with some files, copy what it leaves, and return the copies."""
    (command, files), images = wanted
    with tempfile.TemporaryDirectory() as folder:
        for name, content in files:
            Path(folder, name).write_text(content, encoding="utf-8")
        Path(folder, "configs").symlink_to(DOCS.parent / "configs")
        _run(command, folder)
        for result, image in images:
            image.parent.mkdir(exist_ok=True)
            shutil.copy(Path(folder, result), image)
    return [image for _, image in images]


def _run(command: str, folder: str) -> None:
    """Run a command with the tendon of this environment; print what it says only if it fails."""
    for part in command.split(" && "):
        if part.startswith("tendon "):
            _call(part, folder)
        else:
            _type(part, folder)


def _type(command: str, folder: str) -> None:
    """Run a command in a shell."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(  # noqa: S602 - our own pages
        command,
        shell=True,
        check=False,
        cwd=folder,
        capture_output=True,
        text=True,
        env=os.environ | {"PATH": path},
    )
    if done.returncode:
        sys.stderr.write(done.stdout + done.stderr)
        done.check_returncode()


def _call(command: str, folder: str) -> None:
    """Run a command of tendon in this process; a negative result has figures, too."""
    said = io.StringIO()
    code: str | int | None = None
    with (
        contextlib.chdir(folder),
        contextlib.redirect_stdout(said),
        contextlib.redirect_stderr(said),
    ):
        try:
            cli.main(shlex.split(command)[1:])
        except SystemExit as end:
            code = end.code
    if code not in (None, 0, EXIT_NEGATIVE):
        sys.stderr.write(said.getvalue())
        raise subprocess.CalledProcessError(int(code), command)


if __name__ == "__main__":
    make_figures(*([Path(name) for name in sys.argv[1:]] or sorted(DOCS.glob("*.md"))))
