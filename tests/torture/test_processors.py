"""The same tables on any processor: what NumPy, the C library and Arrow take of it is withheld, level by level."""

import json
import os
import subprocess
import sys

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from .tools import launched, some, study_in

STUDY = """
name = "levels"
[tendon]
pretension = { from = "40 N", to = "240 N", num = 21 }
[spring]
stiffness = { from = "1 kN/m", to = "5 kN/m", num = 5 }
[load]
mass = ["0 kg", "3 kg", "10 kg"]
[motion]
elbow_angle = { from = "-20 deg", to = "90 deg", num = 34 }
[[cases]]
name = "even"
[[cases]]
name = "rough"
sheath.flexor.friction = 0.25
[[cases]]
name = "long"
arm.b1 = "320 mm"
[[cases]]
name = "as printed"
model.slack = "bilateral"
"""
SWEEP = ("sweep", "study.toml", "--out", "run", "--no-figures", "--allow-no-equilibrium", "--json")
CLOSE = 1e-12
"""Of the largest magnitude of a column."""
ASKED = """
import json
import pyarrow
from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__
there = [name for name in __cpu_dispatch__ if __cpu_features__.get(name)]
print(json.dumps({"numpy": there, "arrow": pyarrow.runtime_info().simd_level}))
"""
OF_THE_C_LIBRARY = {
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F,-AVX512VL",
    "OPENBLAS_CORETYPE": "Prescott",
}
ARROW_LEVELS = ("none", "sse4_2", "avx", "avx2")


def features(environment):
    """What NumPy and Arrow use of the processor, beyond what they cannot do without."""
    ran = subprocess.run([sys.executable, "-c", ASKED], check=True, capture_output=True, text=True, env=environment)
    return json.loads(ran.stdout)


def swept(place, environment):
    """A run under an environment: its counts, and its tables."""
    code, out, said = launched(study_in(place, STUDY), {}, *SWEEP, env=os.environ | environment)
    assert code == 0, out + said
    record = json.loads(out)
    counts = {name: value for name, value in record.items() if type(value) is int}
    return counts, {name: pq.read_table(place / f"run/{name}.parquet") for name in ("designs", "states")}


@pytest.fixture(scope="module")
def full(tmp_path_factory, hashes_in):
    """The run of a processor of which nothing is withheld."""
    place = tmp_path_factory.mktemp("full")
    return *swept(place, {}), hashes_in(place / "run")


def assert_close(found, expected):
    assert found.schema.equals(expected.schema, check_metadata=True)
    for name, column in zip(expected.column_names, expected.columns, strict=True):
        if not pa.types.is_floating(column.type):
            assert found.column(name).equals(column), f"{name} is not the same"
            continue
        assert found.column(name).is_null().equals(column.is_null()), f"{name} is null elsewhere"
        one, other = (np.asarray(values.drop_null()) for values in (found.column(name), column))
        most = np.abs(other).max(initial=0.0)
        assert np.abs(one - other).max(initial=0.0) <= CLOSE * most, name


@pytest.mark.parametrize("kept", some([0], [1, 2, 3, 4]))
@pytest.mark.parametrize("of_the_c_library", some([{}], [OF_THE_C_LIBRARY]), ids=["numpy", "numpy and c library"])
def test_the_tables_agree_whatever_numpy_and_the_c_library_may_use(full, tmp_path, kept, of_the_c_library):
    there = features(os.environ)["numpy"]
    if kept > len(there) or (kept == len(there) and not of_the_c_library):
        pytest.skip(f"NumPy chooses among {len(there)} features of this processor: {there}")
    withheld = {"NPY_DISABLE_CPU_FEATURES": " ".join(there[kept:])} | of_the_c_library
    assert features(os.environ | withheld)["numpy"] == there[:kept]
    counts, tables = swept(tmp_path, withheld)
    assert counts == full[0]
    for name, table in tables.items():
        assert_close(table, full[1][name])


@pytest.mark.parametrize("level", some(ARROW_LEVELS[:1], ARROW_LEVELS[1:]))
def test_the_bytes_do_not_know_what_arrow_may_use_of_the_processor(full, tmp_path, hashes_in, level):
    levels = ("none", "sse4_2", "avx", "avx2", "avx512")
    highest = features(os.environ)["arrow"]
    if highest not in levels or levels.index(level) > levels.index(highest):
        pytest.skip(f"the highest that Arrow uses here is {highest}")
    withheld = {"ARROW_USER_SIMD_LEVEL": level.upper()}
    assert features(os.environ | withheld)["arrow"] == level
    swept(tmp_path, withheld)
    assert hashes_in(tmp_path / "run") == full[2]


def test_the_study_of_these_tests_meets_every_status(full):
    counts, tables = full[:2]
    assert counts["no_equilibrium"] > 0
    assert len(set(tables["states"].column("status").to_pylist())) >= 5
    assert len(set(tables["designs"].column("feasible").to_pylist())) == 2
