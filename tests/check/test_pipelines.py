"""The example pipelines do what they say, as far as they can be run here."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from ruamel.yaml import YAML

PIPELINES = Path(__file__).parents[2] / "configs" / "pipelines"


@pytest.fixture
def place(tmp_path):
    return Path(shutil.copytree(PIPELINES, tmp_path / "pipelines"))


def run(command, place, **more):
    environment = os.environ | {
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
        **more,
    }
    kept = {"capture_output": True, "text": True, "timeout": 120}
    return subprocess.run(command, check=False, cwd=place, env=environment, **kept)


def make_rough(place):
    """A sheath so rough that a tendon is beyond its limit."""
    study = place / "suit.toml"
    study.write_text(study.read_text() + "\n[sheath]\nfriction = 0.3\n")


def test_plain_shell_passes_and_fails_on_purpose(place):
    done = run(["sh", "check.sh"], place)
    assert (done.returncode, done.stdout.splitlines()[-1]) == (0, "within limits")
    make_rough(place)
    done = run(["sh", "check.sh"], place)
    assert done.returncode == 4
    assert "design 3 (load_mass 10 kg): has max_tension" in done.stdout


def test_the_makefile_gates_and_keeps_a_baseline(place):
    assert run(["make", "check"], place).returncode == 0
    assert run(["make", "accept"], place).returncode == 0
    done = run(["make", "check"], place)
    assert "nothing changed" in done.stdout
    make_rough(place)
    assert run(["make", "check"], place).returncode != 0


@pytest.mark.parametrize("task", [1, 2, 3])
def test_a_task_of_the_slurm_array_sweeps_its_case(place, task):
    done = run(["bash", "slurm.sh", "suit.toml", "cases.txt"], place, SLURM_ARRAY_TASK_ID=str(task))
    assert done.returncode == 0, done.stderr
    assert (place / "results" / f"task-{task}" / "run.json").exists()


def test_one_sweep_on_the_nodes_of_a_slurm_job(place, tmp_path):
    """A stand-in for srun starts the worker here; scheduler, worker and sweep are real, and leave only the run."""
    programs = tmp_path / "programs"
    programs.mkdir()
    srun = programs / "srun"
    srun.write_text('#!/bin/sh\nexec "$@"\n')
    srun.chmod(0o755)
    path = os.pathsep.join([str(programs), str(Path(sys.executable).parent), os.environ["PATH"]])
    done = run(
        ["bash", "dask_slurm.sh", "suit.toml", "results/suit"],
        place,
        PATH=path,
        SLURM_CPUS_PER_TASK="1",
    )
    assert done.returncode == 0, done.stderr
    plain = run(
        ["tendon", "sweep", "suit.toml", "--out", "results/plain", "--no-figures", "--quiet"], place
    )
    assert plain.returncode == 0, plain.stderr
    first, second = (place / "results" / name / "designs.parquet" for name in ("suit", "plain"))
    assert first.read_bytes() == second.read_bytes()
    assert not list(place.glob("dask-*"))


@pytest.mark.parametrize("friction", ["0.06", "0.3"])
def test_the_steps_of_the_job_run_and_the_gate_closes(place, friction):
    job = YAML(typ="safe").load(place / "ci.yml")["jobs"]["check"]
    codes = {}
    for step in job["steps"]:
        if "run" in step and step["name"] != "install":
            command = step["run"].replace("${{ matrix.friction }}", friction)
            codes[step["name"]] = run(
                ["bash", "-c", command], place, GITHUB_STEP_SUMMARY="summary.md"
            ).returncode
    assert codes == {"sweep": 0, "gate": 0 if friction == "0.06" else 4}
    summary = (place / "summary.md").read_text()
    assert ("max_tension" in summary) is (friction == "0.3")
