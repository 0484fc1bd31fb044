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


def make_figures(page: Path) -> list[Path]:
    """Make all figures of a page, and the pages of HTML that it links to.

    Returns:
        Their files.

    Raises:
        CalledProcessError: A command failed.
    """
    text = page.read_text(encoding="utf-8")
    made = []
    pages = [(command, result, f"pages/{link}") for command, result, link in PAGE.findall(text)]
    for command, result, image in [*RECIPE.findall(text), *pages]:
        with tempfile.TemporaryDirectory() as folder:
            for name, content in FILE.findall(text):
                Path(folder, name).write_text(content, encoding="utf-8")
            Path(folder, "configs").symlink_to(DOCS.parent / "configs")
            _run(command, folder)
            target = page.parent / image
            target.parent.mkdir(exist_ok=True)
            shutil.copy(Path(folder, result), target)
        made.append(target)
    return made


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
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for figures in pool.map(make_figures, pages):
            sys.stdout.write("".join(f"{figure}\n" for figure in figures))
