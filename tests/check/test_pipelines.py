"""The example pipelines do what they say, as far as they can be run here."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from ruamel.yaml import YAML

import tendon_cli as tendon_library

PIPELINES = Path(__file__).parents[2] / "configs" / "pipelines"
PROGRAMS = Path(sys.executable).parent


@pytest.fixture
def folder(tmp_path):
    """Return a copy of the folder of pipelines."""
    return Path(shutil.copytree(PIPELINES, tmp_path / "pipelines"))


def run(command, folder, **variables):
    """Run a command in a folder, with `tendon` on its path and variables of the environment."""
    path = f"{PROGRAMS}{os.pathsep}{os.environ['PATH']}"
    return subprocess.run(
        command,
        check=False,
        cwd=folder,
        env=os.environ | {"PATH": path} | variables,
        capture_output=True,
        text=True,
        timeout=120,
    )


def make_rough(folder):
    """Make the sheath so rough that a tendon is beyond its limit."""
    study = folder / "suit.toml"
    study.write_text(study.read_text() + "\n[sheath]\nfriction = 0.3\n")


def test_plain_shell_passes_and_fails_on_purpose(folder):
    done = run(["sh", "check.sh"], folder)
    assert done.returncode == 0
    assert done.stdout.splitlines()[-1] == "within limits"
    make_rough(folder)
    done = run(["sh", "check.sh"], folder)
    assert done.returncode == 4
    assert "design 2 (load_mass 3 kg): has max_tension" in done.stdout


def test_the_makefile_gates_and_keeps_a_baseline(folder):
    assert run(["make", "accept"], folder).returncode == 0
    done = run(["make", "check"], folder)
    assert "nothing changed" in done.stdout
    make_rough(folder)
    assert run(["make", "check"], folder).returncode != 0


def test_a_task_of_the_slurm_array_sweeps_its_case(folder):
    command = ["bash", "slurm.sh", "suit.toml", "cases.txt"]
    done = run(command, folder, SLURM_ARRAY_TASK_ID="3")
    assert done.returncode == 0, done.stderr
    assert (folder / "results" / "task-3" / "run.json").exists()


def test_one_sweep_on_the_nodes_of_a_slurm_job(folder, tmp_path):
    """A sweep of the job script leaves only its run.

    A stand-in for srun starts the worker here; scheduler, worker and sweep are real.
    """
    programs = tmp_path / "programs"
    programs.mkdir()
    srun = programs / "srun"
    srun.write_text('#!/bin/sh\nexec "$@"\n')
    srun.chmod(0o755)
    path = os.pathsep.join([str(programs), str(PROGRAMS), os.environ["PATH"]])
    command = ["bash", "dask_slurm.sh", "suit.toml", "results/suit"]
    done = run(command, folder, PATH=path, SLURM_CPUS_PER_TASK="1")
    assert done.returncode == 0, done.stderr
    tendon_library.sweep(folder / "suit.toml", folder / "results/plain")
    on_nodes = folder / "results/suit/designs.parquet"
    expected = folder / "results/plain/designs.parquet"
    assert on_nodes.read_bytes() == expected.read_bytes()
    assert not list(folder.glob("dask-*"))


def test_the_steps_of_the_job_run_and_the_gate_closes(folder):
    job = YAML(typ="safe").load(folder / "ci.yml")["jobs"]["check"]
    codes = {}
    for step in job["steps"]:
        if "run" in step and step["name"] != "install":
            script = step["run"].replace("${{ matrix.friction }}", "0.3")
            done = run(["bash", "-c", script], folder, GITHUB_STEP_SUMMARY="summary.md")
            codes[step["name"]] = done.returncode
    assert codes == {"sweep": 0, "gate": 4}
    assert "max_tension" in (folder / "summary.md").read_text()
