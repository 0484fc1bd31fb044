"""Tables are the same on any processor.

Features that NumPy, the C library and Arrow use of it are withheld, level by level.
"""

import json
import os
import subprocess
import sys

import pandas as pd
import pytest

from tests.sampled import quick_and_torture
from tools.torture.runs import launched, study_in

STUDY = """
name = "levels"
[tendon]
pretension = { from = "40 N", to = "240 N", num = 7 }
[spring]
stiffness = { from = "1 kN/m", to = "5 kN/m", num = 3 }
[load]
mass = ["0 kg", "3 kg", "10 kg"]
[motion]
elbow_angle = { from = "-20 deg", to = "90 deg", num = 23 }
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
"""Permitted difference, as a share of the largest magnitude of a column."""
FEATURES = """
import json
import pyarrow
from numpy._core._multiarray_umath import __cpu_dispatch__, __cpu_features__
available = [name for name in __cpu_dispatch__ if __cpu_features__.get(name)]
print(json.dumps({"numpy": available, "arrow": pyarrow.runtime_info().simd_level}))
"""
WITHHELD_FROM_THE_C_LIBRARY = {
    "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX512F,-AVX512VL",
    "OPENBLAS_CORETYPE": "Prescott",
}
ARROW_LEVELS = ("none", "sse4_2", "avx", "avx2")


def features(environment):
    """Return the features of the processor that NumPy and Arrow use beyond their baseline."""
    ran = subprocess.run(
        [sys.executable, "-c", FEATURES],
        check=True,
        capture_output=True,
        text=True,
        env=environment,
    )
    return json.loads(ran.stdout)


def swept(place, environment):
    """Run the study under an environment; return the counts in its record, and its tables."""
    code, out, err = launched(study_in(place, STUDY), {}, *SWEEP, env=os.environ | environment)
    assert code == 0, out + err
    counts = {name: value for name, value in json.loads(out).items() if type(value) is int}
    names = ("designs", "states")
    tables = {name: pd.read_parquet(place / f"run/{name}.parquet") for name in names}
    return counts, tables


@pytest.fixture(scope="module")
def full(tmp_path_factory, hashes_in):
    """Return counts, tables and hashes of a run from which nothing is withheld.

    It meets every status.
    """
    place = tmp_path_factory.mktemp("full")
    counts, tables = swept(place, {})
    assert counts["no_equilibrium"] > 0
    assert tables["designs"]["feasible"].nunique() == 2
    assert tables["states"]["status"].nunique() >= 5
    return counts, tables, hashes_in(place / "run")


@pytest.mark.parametrize("kept", quick_and_torture([0], [1, 2, 3, 4]))
@pytest.mark.parametrize(
    "for_the_c_library",
    quick_and_torture([{}], [WITHHELD_FROM_THE_C_LIBRARY]),
    ids=["numpy", "numpy and c library"],
)
def test_the_tables_agree_whatever_numpy_and_the_c_library_may_use(
    full, tmp_path, kept, for_the_c_library
):
    available = features(os.environ)["numpy"]
    withholds_nothing = kept == len(available) and not for_the_c_library
    if kept > len(available) or withholds_nothing:
        pytest.skip(f"NumPy chooses among {len(available)} features of this processor: {available}")
    withheld = {"NPY_DISABLE_CPU_FEATURES": " ".join(available[kept:])} | for_the_c_library
    assert features(os.environ | withheld)["numpy"] == available[:kept]
    counts, tables = swept(tmp_path, withheld)
    expected_counts, expected_tables, _ = full
    assert counts == expected_counts
    for name, table in expected_tables.items():
        for column in table:
            expected = table[column]
            largest = expected.abs().max() if expected.dtype == float else 0.0
            pd.testing.assert_series_equal(
                tables[name][column], expected, rtol=0.0, atol=CLOSE * largest
            )


@pytest.mark.parametrize("level", quick_and_torture(ARROW_LEVELS[:1], ARROW_LEVELS[1:]))
def test_the_bytes_do_not_depend_on_what_arrow_may_use_of_the_processor(
    full, tmp_path, hashes_in, level
):
    withheld = {"ARROW_USER_SIMD_LEVEL": level.upper()}
    if features(os.environ | withheld)["arrow"] != level:
        pytest.skip(f"Arrow uses less than {level} here")
    swept(tmp_path, withheld)
    _, _, expected = full
    assert hashes_in(tmp_path / "run") == expected
