"""Build a release and check that it holds all of the package and nothing else.

Run it as `python -m tools.release dist`.
"""

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
    "tendon_cli/reports/page/page.html",
    "tendon_cli/reports/page/page.css",
    "tendon_cli/reports/plotly/LICENSE",
}
"""Files that are easily left out, in case the rules below are wrong."""


def of_the_package():
    """Return every file of the package in the working tree but compiled ones and caches."""
    return {
        file.relative_to(ROOT).as_posix()
        for file in (ROOT / "tendon_cli").rglob("*")
        if file.is_file()
        and "__pycache__" not in file.parts
        and file.suffix not in (".so", ".pyd", ".pyc")
    }


def of_the_configs():
    """Return every file of the studies and readings that the documentation uses."""
    return {
        file.relative_to(ROOT).as_posix()
        for file in (ROOT / "configs").rglob("*")
        if file.is_file()
    }


def of_a_wheel():
    """Return the files of a wheel but compiled code: package and examples of `init --from`."""
    package = {name for name in of_the_package() if not name.endswith((".c", ".h"))}
    examples = {
        f"tendon_cli/examples/{name.removeprefix('configs/')}"
        for name in of_the_configs()
        if name.endswith((".toml", ".csv"))
    }
    return package | examples


def build(source, folder):
    """Build sdist and wheel; on Linux the wheel is tagged for the oldest C library it runs with."""
    run_module("build", "--outdir", folder, source)
    if sys.platform == "linux":
        for wheel in folder.glob("*-linux_*.whl"):
            run_module("auditwheel", "repair", "--wheel-dir", folder, wheel)
            wheel.unlink()


def run_module(module, *words):
    """Run a module of this environment, with its programs on the path; raise if it fails."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    command = [sys.executable, "-m", module, *map(str, words)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=os.environ | {"PATH": path})


def image_of(source):
    """Build the container and run it. Return the result as a line."""
    tool = next(filter(shutil.which, ("docker", "buildah")), None)
    if tool is None:
        return "the image was not built: there is neither Docker nor Buildah here"

    def ran(*words):
        return subprocess.run([tool, *map(str, words)], check=False, capture_output=True, text=True)

    built = ran("build", "--tag", "tendon", source)
    if built.returncode:
        reasons = built.stderr.strip().splitlines() or ["no reason given"]
        return f"the image was not built: {reasons[-1]}"
    if tool == "docker":
        answered = ran("run", "--rm", "tendon", "--version")
    else:
        answered = ran("run", ran("from", "tendon").stdout.strip(), "--", "tendon", "--version")
    return f"the image answers {answered.stdout.strip() or answered.stderr.strip()}"


def faults_of_wheel(path):
    """List files that a wheel lacks or should not have, and wrong tags, one line each."""
    with zipfile.ZipFile(path) as wheel:
        names = wheel.namelist()
    found = {name for name in names if ".dist-info/" not in name and not name.endswith("/")}
    compiled = {name for name in found if name.startswith("tendon_cli/kernel/_native.")}
    faults = []
    if len(compiled) != 1:
        faults.append("has no compiled kernel")
    if "-cp311-abi3-" not in path.name:
        faults.append("is not tagged for every Python from 3.11 on (cp311-abi3)")
    if "-linux_" in path.name:
        faults.append("is tagged for this machine's Linux only (no manylinux)")
    return faults + _difference(of_a_wheel() | NEEDED, found - compiled)


def faults_of_sdist(path):
    """List files that a source distribution lacks or should not have, one line each."""
    with tarfile.open(path) as sdist:
        names = {member.name.partition("/")[2] for member in sdist.getmembers() if member.isfile()}
    found = {name for name in names if ".egg-info/" not in name} - BY_SETUPTOOLS
    return _difference(of_the_package() | of_the_configs() | NEEDED | OF_THE_SOURCE, found)


def _difference(expected, found):
    lacking = [f"lacks {name}" for name in sorted(expected - found)]
    surplus = [f"has {name}" for name in sorted(found - expected)]
    return lacking + surplus


def main(folder):
    """Check the one wheel and the one source distribution of a folder. Return the exit code."""
    wheels = sorted(folder.glob("*.whl"))
    sdists = sorted(folder.glob("*.tar.gz"))
    faults = []
    if len(wheels) != 1 or len(sdists) != 1:
        faults.append(f"{folder} holds no single wheel and source distribution")
    faults += [f"{path.name} {fault}" for path in wheels for fault in faults_of_wheel(path)]
    faults += [f"{path.name} {fault}" for path in sdists for fault in faults_of_sdist(path)]
    lines = faults or [f"{path.name} is whole" for path in (*wheels, *sdists)]
    sys.stdout.write("\n".join(lines) + "\n")
    return bool(faults)


if __name__ == "__main__":
    build(ROOT, Path(sys.argv[1]))
    faults = main(Path(sys.argv[1]))
    sys.stdout.write(f"{image_of(ROOT)}\n")
    sys.exit(faults)
