"""Compiled code is used where there is any of the right version, and changes no byte of a table."""

import os
import shutil
import sys
import sysconfig
from pathlib import Path

import pytest
from numpy.random import mtrand

from tendon_cli.sweep import lines, native

from .studies import NEVER_PAST_THE_CENTRE, PRETENSION_PER_SIDE, STUDY

HERE = Path(native.__file__).parent
needs_code = pytest.mark.skipif(native.load(HERE) is None, reason="tendon was installed without a C compiler")

WEIGHTLESS = """
arm = { forearm_mass = 0, upper_arm_angle = ["-30 deg", "0 deg", "30 deg"], elbow_radius = ["4 cm", "5 cm"] }
tendon = { pretension = ["0 N", "10 N", "100 N"] }
motion = { elbow_angle = { from = "-30 deg", to = "170 deg", num = 21 } }
"""
"""Where much is nought, and might be minus nought."""

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
"""Pretension by case and axis."""


@pytest.fixture
def wanted(monkeypatch):
    """Choose whether compiled code is wanted; afterwards it is as before."""

    def choose(*, code):
        monkeypatch.setenv(native.UNWANTED, "" if code else "1")
        native.library.cache_clear()
        assert (native.library() is not None) == code

    yield choose
    monkeypatch.undo()
    native.library.cache_clear()


@needs_code
@pytest.mark.parametrize(
    "text",
    [STUDY, NEVER_PAST_THE_CENTRE, PRETENSION_PER_SIDE, WEIGHTLESS, LINKED],
    ids=["everything", "never past the centre", "pretension per side", "weightless", "linked"],
)
def test_a_sweep_writes_the_same_bytes_with_and_without_it(new_sweep, tmp_path, wanted, text):
    hashes = []
    for code in (True, False):
        wanted(code=code)
        for block_states in (2**15, 600, 1):
            swept = new_sweep(text, tmp_path, block_states=block_states, out=f"{code}-{block_states}")
            hashes.append(swept.hashes)
    assert all(each == hashes[0] for each in hashes)
    assert len(hashes[0]) == 2


@needs_code
def test_the_command_writes_the_same_bytes_without_it(outside, workplace, hashes_in):
    (workplace / "study.toml").write_text(STUDY, encoding="utf-8")
    environment = {name: value for name, value in os.environ.items() if name != native.UNWANTED}
    for out, more in (("with", {}), ("without", {native.UNWANTED: "1"})):
        words = ("sweep", "study.toml", "--out", out, "--no-figures", "--allow-no-equilibrium")
        ran = outside(*words, env=environment | more)
        assert ran.exit == 0, ran.err
    assert hashes_in(workplace / "with") == hashes_in(workplace / "without")


@needs_code
def test_a_sweep_looks_by_it_alone_where_it_is_there(new_sweep, tmp_path, wanted, monkeypatch):
    monkeypatch.setattr(lines, "look", None)
    wanted(code=True)
    new_sweep(LINKED, tmp_path)


@needs_code
def test_code_of_another_version_is_not_used(monkeypatch):
    monkeypatch.setattr(native, "_VERSION", native._VERSION + 1)
    assert native.load(HERE) is None


def test_what_is_no_code_is_passed_over(tmp_path):
    for name, content in (("c", b"int x;"), ("so", b""), ("xyz.so", b"\x7fELF" + bytes(range(256)) * 40)):
        (tmp_path / f"_native.{name}").write_bytes(content)
    (tmp_path / "_native.folder").mkdir()
    (tmp_path / "_native.nowhere").symlink_to(tmp_path / "nothing")
    assert native.load(tmp_path) is None
    for code in HERE.glob("_native.*"):
        shutil.copy(code, tmp_path / f"_native.zz.{code.name}")
    assert (native.load(tmp_path) is None) == (native.load(HERE) is None)


def test_a_library_that_is_not_ours_is_passed_over(tmp_path):
    """NumPy's has no version to tell."""
    shutil.copy(mtrand.__file__, tmp_path / "_native.other.so")
    assert native.load(tmp_path) is None


def test_make_compiles_it_where_there_is_a_compiler():
    compiler = os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc"
    if shutil.which(compiler.split()[0]) is None:
        pytest.skip("no C compiler")
    if not Path(sys.prefix, ".ready").exists():
        pytest.skip("tendon was not installed by make")
    assert native.load(HERE) is not None
