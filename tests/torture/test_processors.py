"""The same tables on any processor: what NumPy, the C library and Arrow take of it is withheld, level by level."""

import json
import os
import subprocess
import sys

import pandas as pd
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
    ran = subprocess.run(
        [sys.executable, "-c", ASKED], check=True, capture_output=True, text=True, env=environment
    )
    return json.loads(ran.stdout)


def swept(place, environment):
    """A run under an environment: its counts, and its tables."""
    code, out, said = launched(study_in(place, STUDY), {}, *SWEEP, env=os.environ | environment)
    assert code == 0, out + said
    counts = {name: value for name, value in json.loads(out).items() if type(value) is int}
    return counts, {
        name: pd.read_parquet(place / f"run/{name}.parquet") for name in ("designs", "states")
    }


@pytest.fixture(scope="module")
def full(tmp_path_factory, hashes_in):
    """The run of a processor of which nothing is withheld; it meets every status."""
    place = tmp_path_factory.mktemp("full")
    counts, tables = swept(place, {})
    assert (counts["no_equilibrium"] > 0, tables["designs"]["feasible"].nunique()) == (True, 2)
    assert tables["states"]["status"].nunique() >= 5
    return counts, tables, hashes_in(place / "run")


@pytest.mark.parametrize("kept", some([0], [1, 2, 3, 4]))
@pytest.mark.parametrize(
    "of_the_c_library", some([{}], [OF_THE_C_LIBRARY]), ids=["numpy", "numpy and c library"]
)
def test_the_tables_agree_whatever_numpy_and_the_c_library_may_use(
    full, tmp_path, kept, of_the_c_library
):
    there = features(os.environ)["numpy"]
    if kept > len(there) or (kept == len(there) and not of_the_c_library):
        pytest.skip(f"NumPy chooses among {len(there)} features of this processor: {there}")
    withheld = {"NPY_DISABLE_CPU_FEATURES": " ".join(there[kept:])} | of_the_c_library
    assert features(os.environ | withheld)["numpy"] == there[:kept]
    counts, tables = swept(tmp_path, withheld)
    assert counts == full[0]
    for name, expected in full[1].items():
        for column in expected:
            most = expected[column].abs().max() if expected[column].dtype == float else 0.0
            pd.testing.assert_series_equal(
                tables[name][column], expected[column], rtol=0.0, atol=CLOSE * most
            )


@pytest.mark.parametrize("level", some(ARROW_LEVELS[:1], ARROW_LEVELS[1:]))
def test_the_bytes_do_not_know_what_arrow_may_use_of_the_processor(
    full, tmp_path, hashes_in, level
):
    withheld = {"ARROW_USER_SIMD_LEVEL": level.upper()}
    if features(os.environ | withheld)["arrow"] != level:
        pytest.skip(f"Arrow uses less than {level} here")
    swept(tmp_path, withheld)
    assert hashes_in(tmp_path / "run") == full[2]
