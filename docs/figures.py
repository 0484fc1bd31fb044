"""Make the figures of the pages: `python docs/figures.py [PAGE]`.

Above an image, or a link to a page of HTML, stands how it is made,
`<!-- made by: COMMAND -> FILE -->`: a command for a shell, in a folder with the files of the page
(blocks that begin with `# file: NAME`) and `configs`, and the file that it leaves. `make docs`
makes those of all pages; pages of HTML go to `pages`, from where Sphinx copies them beside its own.
The figure of the README is kept in the repository, made by `python docs/figures.py README.md`.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

DOCS = Path(__file__).parent
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
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(_make, wanted.keys(), wanted.values()))
    return [image for images in wanted.values() for _, image in images]


def _make(run: tuple[str, Files], images: Images) -> None:
    """Run a command in a folder with some files, and copy what it leaves."""
    command, files = run
    with tempfile.TemporaryDirectory() as folder:
        for name, content in files:
            Path(folder, name).write_text(content, encoding="utf-8")
        Path(folder, "configs").symlink_to(DOCS.parent / "configs")
        _run(command, folder)
        for result, image in images:
            image.parent.mkdir(exist_ok=True)
            shutil.copy(Path(folder, result), image)


def _run(command: str, folder: str) -> None:
    """Run a command with the tendon of this environment; print what it says only if it fails."""
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


if __name__ == "__main__":
    pages = [Path(name) for name in sys.argv[1:]] or sorted(DOCS.glob("*.md"))
    sys.stdout.write("".join(f"{figure}\n" for figure in make_figures(*pages)))
