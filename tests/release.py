"""What a release holds: all of the package and nothing else; `python -m tests.release dist` builds and checks it."""

import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).parent.parent
OF_THE_SOURCE = {
    "CHANGELOG.md",
    "CITATION.cff",
    "LICENSE",
    "MANIFEST.in",
    "README.md",
    "pyproject.toml",
    "setup.py",
}
BY_SETUPTOOLS = {"PKG-INFO", "setup.cfg"}
NEEDED = {
    "tendon_cli/py.typed",
    "tendon_cli/studies/starter.toml",
    "tendon_cli/studies/starter.yaml",
    "tendon_cli/studies/people/ansur2_arm.toml",
    "tendon_cli/paper/studies/fig07.toml",
    "tendon_cli/reports/page/page.css",
    "tendon_cli/reports/plotly/LICENSE",
}
"""Some of what is easily left out, by name, in case the rule below is wrong."""


def of_the_package():
    """Every file of the package in the working tree that is neither compiled nor a cache."""
    files = (
        file
        for file in (ROOT / "tendon_cli").rglob("*")
        if file.is_file() and "__pycache__" not in file.parts
    )
    return {
        file.relative_to(ROOT).as_posix()
        for file in files
        if file.suffix not in (".so", ".pyd", ".pyc")
    }


def of_the_configs():
    """Every file of the studies and readings that the documentation uses."""
    return {
        file.relative_to(ROOT).as_posix()
        for file in (ROOT / "configs").rglob("*")
        if file.is_file()
    }


def of_a_wheel():
    """What a wheel holds beside compiled code: the package, and the examples that `tendon init --from` copies."""
    examples = {f"tendon_cli/examples/{name.removeprefix('configs/')}" for name in of_the_configs()}
    return {name for name in of_the_package() if Path(name).suffix not in (".c", ".h")} | {
        name for name in examples if name.endswith((".toml", ".csv"))
    }


def build(source, folder):
    """Build sdist and wheel; on Linux the wheel gets the tag of the oldest C library that it runs with."""
    called("build", "--outdir", folder, source)
    if sys.platform == "linux":
        for wheel in folder.glob("*-linux_*.whl"):
            called("auditwheel", "repair", "--wheel-dir", folder, wheel)
            wheel.unlink()


def called(module, *words):
    """Run a module of this environment, with its programs on the path, and stop where it fails."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    command = [sys.executable, "-m", module, *map(str, words)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=os.environ | {"PATH": path})


def image_of(source):
    """What came of building the container and of running it, as a line."""
    tool = next(filter(shutil.which, ("docker", "buildah")), None)
    if tool is None:
        return "the image was not built: there is neither Docker nor Buildah here"

    def ran(*words):
        return subprocess.run([tool, *map(str, words)], check=False, capture_output=True, text=True)

    built = ran("build", "--tag", "tendon", source)
    if built.returncode:
        return f"the image was not built: {(built.stderr.strip().splitlines() or ['no reason given'])[-1]}"
    if tool == "docker":
        answered = ran("run", "--rm", "tendon", "--version")
    else:
        answered = ran("run", ran("from", "tendon").stdout.strip(), "--", "tendon", "--version")
    return f"the image answers {answered.stdout.strip() or answered.stderr.strip()}"


def faults_of_wheel(path):
    """What a wheel lacks and what it has too much, one line each."""
    with zipfile.ZipFile(path) as wheel:
        found = {
            name
            for name in wheel.namelist()
            if ".dist-info/" not in name and not name.endswith("/")
        }
    compiled = {name for name in found if name.startswith("tendon_cli/kernel/_native.")}
    faults = [] if len(compiled) == 1 else ["has no compiled kernel"]
    faults += (
        []
        if "-cp311-abi3-" in path.name
        else ["is not tagged for every Python from 3.11 on (cp311-abi3)"]
    )
    faults += (
        ["is tagged for this machine's Linux only (no manylinux)"] if "-linux_" in path.name else []
    )
    return faults + _difference(of_a_wheel() | NEEDED, found - compiled)


def faults_of_sdist(path):
    """What a source distribution lacks and what it has too much, one line each."""
    with tarfile.open(path) as sdist:
        names = {member.name.partition("/")[2] for member in sdist.getmembers() if member.isfile()}
    found = {name for name in names if ".egg-info/" not in name} - BY_SETUPTOOLS
    return _difference(of_the_package() | of_the_configs() | NEEDED | OF_THE_SOURCE, found)


def _difference(expected, found):
    return [f"lacks {name}" for name in sorted(expected - found)] + [
        f"has {name}" for name in sorted(found - expected)
    ]


def main(folder):
    """Check the one wheel and the one source distribution of a folder; the exit code."""
    wheels, sdists = sorted(folder.glob("*.whl")), sorted(folder.glob("*.tar.gz"))
    faults = (
        []
        if len(wheels) == len(sdists) == 1
        else [f"{folder} holds no single wheel and source distribution"]
    )
    faults += [f"{path.name} {fault}" for path in wheels for fault in faults_of_wheel(path)]
    faults += [f"{path.name} {fault}" for path in sdists for fault in faults_of_sdist(path)]
    sys.stdout.write(
        "\n".join(faults or [f"{path.name} is whole" for path in (*wheels, *sdists)]) + "\n"
    )
    return bool(faults)


if __name__ == "__main__":
    build(ROOT, Path(sys.argv[1]))
    faults = main(Path(sys.argv[1]))
    sys.stdout.write(f"{image_of(ROOT)}\n")
    sys.exit(faults)
