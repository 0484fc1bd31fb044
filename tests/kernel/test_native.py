"""Compiled code is used if there is any of the right version, and changes no byte of a table."""

import os
import shutil
import sys
import sysconfig
from pathlib import Path

import numpy as np
import pytest

from tendon_cli import kernel
from tendon_cli.quantities import OF_STATES
from tests.sweep.studies import NEVER_PAST_THE_CENTRE, PRETENSION_PER_SIDE, STUDY

from .filling import needs_code

WEIGHTLESS = """
[arm]
forearm_mass = 0
upper_arm_angle = ["-30 deg", "0 deg", "30 deg"]
elbow_radius = ["4 cm", "5 cm"]
[tendon]
pretension = ["0 N", "10 N", "100 N"]
[motion]
elbow_angle = { from = "-30 deg", to = "170 deg", num = 21 }
"""
"""A study in which much is zero, and might be minus zero."""

LINKED = """
[tendon]
pretension = ["10 N", "20 N", "30 N"]
[[cases]]
name = "even"
[[cases]]
name = "own"
tendon = { flexor = { pretension = "99 N" } }
[motion]
elbow_angle = { from = "-30 deg", to = "120 deg", num = 97 }
"""
"""A study whose pretension varies by case and by axis."""


def look_for_code_again():
    kernel.native.cache_clear()


@pytest.fixture
def wanted(monkeypatch):
    """Yield a function that chooses whether compiled code is used; afterwards it is as before."""

    def choose(*, code):
        monkeypatch.setenv(kernel.NO_COMPILED_VARIABLE, "" if code else "1")
        look_for_code_again()
        assert (kernel.native() is not None) == code

    yield choose
    monkeypatch.undo()
    look_for_code_again()


@needs_code
@pytest.mark.parametrize(
    "text",
    [STUDY, NEVER_PAST_THE_CENTRE, PRETENSION_PER_SIDE, WEIGHTLESS, LINKED],
    ids=["everything", "never past the centre", "pretension per side", "weightless", "linked"],
)
def test_a_sweep_writes_the_same_bytes_with_and_without_it(new_sweep, tmp_path, wanted, text):
    hashes = []
    for code, blocks in ((True, (2**15, 600, 1)), (False, (2**15, 600))):
        wanted(code=code)
        for block_states in blocks:
            out = f"{code}-{block_states}"
            swept = new_sweep(text, tmp_path, block_states=block_states, out=out)
            hashes.append(swept.hashes)
    assert len(hashes[0]) == 2
    for by_name in hashes:
        assert by_name == hashes[0]


@needs_code
def test_a_sweep_goes_by_it_alone_where_it_is_there(new_sweep, tmp_path, wanted, monkeypatch):
    monkeypatch.setattr(kernel, "State", None)
    wanted(code=True)
    new_sweep(LINKED, tmp_path)


@needs_code
def test_code_of_another_version_is_not_used(monkeypatch):
    monkeypatch.setattr(kernel, "VERSION", kernel.VERSION + 1)
    assert kernel.native.__wrapped__() is None


COMMON = (
    "moment_arm",
    "pulling_arm",
    "flexor_slope",
    "flexor_travel",
    "extensor_travel",
    "sine",
    "cosine",
    "other_torque",
    "other_slope",
    "pressed",
    "spring_room",
    "gravity_moment",
    "extensor_arm",
    "extensor_slope",
    "flexor_radius",
    "ratio",
    "unilateral",
)
BY_SIDE = (
    "capstan",
    "tendon",
    "spring",
    "anchor",
    "tendon_resting",
    "spring_resting",
    "pretension",
)
NAMES = [*COMMON, *(f"{side}_{name}" for side in ("flexor", "extensor") for name in BY_SIDE)]
GIVEN = {name: np.ones((2, 1, 4)) for name in NAMES}
"""Inputs of a block of two designs, one direction and four angles."""


@needs_code
@pytest.mark.parametrize(
    ("fault", "problem"),
    [
        ({"given": GIVEN | {"sine": np.zeros((2, 3))}}, "sine has the shape"),
        (
            {"given": GIVEN | {"sine": np.zeros((2, 1, 8))[..., ::2]}},
            "contiguous along the last axis",
        ),
        ({"given": GIVEN | {"ratio": np.zeros((2, 1, 4), np.float32)}}, "values of float32"),
        ({"given": {}}, "moment_arm"),
        ({"shape": (3, 1, 4)}, "moment_arm has the shape"),
        ({"shape": (2, 1, 1)}, "moment_arm has the shape"),
        ({"shape": (1, 4)}, "moment_arm has the shape"),
        ({"shape": (2, 0, 4)}, "an axis is empty"),
        ({"shape": (4,)}, "1 axes, expected 2 to 64"),
        ({"columns": {"motor_torque": np.zeros(7)}}, "motor_torque has the shape"),
        ({"columns": {"motor_torque": np.zeros(16)[::2]}}, "motor_torque has the shape"),
        ({"columns": {"status": np.zeros(8)}}, "values of float64"),
        ({"first": 1}, "are not among the states"),
        ({"first": -1}, "are not among the states"),
        ({"keys": {"design": np.zeros((2, 1, 4))}}, "design"),
    ],
)
def test_it_refuses_what_does_not_fit(fault, problem):
    call = {
        "shape": (2, 1, 4),
        "given": GIVEN,
        "keys": {},
        "columns": {},
        "first": 0,
        "count": 8,
    }
    kernel.native().rows(*call.values())
    with pytest.raises((ValueError, KeyError), match=problem):
        kernel.native().rows(*(call | fault).values())


def test_make_compiles_it_where_there_is_a_compiler():
    compiler = os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc"
    if shutil.which(compiler.split()[0]) is None:
        pytest.skip("no C compiler")
    if not Path(sys.prefix, ".ready").exists():
        pytest.skip("tendon was not installed by make")
    assert kernel.native.__wrapped__() is not None


@needs_code
def test_every_column_that_it_writes_is_one_of_states():
    """NumPy works out the others, so that a slip in a name would only show as lost time."""
    assert set(kernel.native().results) <= set(OF_STATES)
