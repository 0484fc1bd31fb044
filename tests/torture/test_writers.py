"""What is not a sweep writes whole files, too: an error at any step is exit 5, and what was there before stays."""

import errno
import os

import pytest

from .test_io_errors import Faults
from .tools import some, study_in

READINGS = "cell 1,cell 2\n1.2,1\n2.4,2\n1,1.2\n2,2.4\n"
FIT = ("fit-friction", "cells.csv", "--bend-angle", "144 deg")
WRITERS = {
    "friction.toml": (*FIT, "--out", "friction.toml"),
    "fit.png": (*FIT, "--plot", "fit.png"),
    "arm.svg": ("plot", "study.toml", "--arm", "--out", "arm.svg"),
}
STEPS = ("open", "write", "fsync file", "rename")
NUMBERS = (errno.ENOSPC, errno.EIO, errno.EDQUOT, errno.EROFS, errno.EACCES)
BEFORE = b"what was there before"


def failing(tendon, words, place, at, number):
    """A command whose step of that number fails."""
    with pytest.MonkeyPatch.context() as patch:
        faults = Faults(patch, "")
        faults.below = str(place)
        patch.chdir(place)
        faults.begin(at, number=number)
        ran = tendon(*words[:-1], place / words[-1], "--json")
        return ran, [kind for kind, _ in faults.seen][: at + 1]


@pytest.mark.parametrize("stands", [True, False], ids=["replaced", "new"])
@pytest.mark.parametrize("name", some(["friction.toml"], ["fit.png", "arm.svg"]))
def test_an_error_at_any_step_of_any_file_is_exit_5_and_changes_nothing(tendon, workplace, muttered, name, stands):
    study_in(workplace, "")
    (workplace / "cells.csv").write_text(READINGS, encoding="utf-8")
    file = workplace / name
    assert tendon(*WRITERS[name]).exit == 0  # what is made at the first import only is made here
    whole = file.read_bytes()
    file.unlink()
    if stands:
        file.write_bytes(BEFORE)
    before = sorted(workplace.iterdir())
    for at in range(len(STEPS)):
        for number in NUMBERS if name == "friction.toml" else NUMBERS[:2]:
            ran, seen = failing(tendon, WRITERS[name], workplace, at, number)
            assert seen == list(STEPS[: at + 1])
            assert (ran.exit, ran.json["error"]["kind"], ran.err) == (5, "output", "")
            assert os.strerror(number) in ran.json["error"]["message"]
            assert name in ran.json["error"]["where"]
            assert sorted(workplace.iterdir()) == before
            assert not stands or file.read_bytes() == BEFORE
    assert tendon(*WRITERS[name]).exit == 0
    assert file.read_bytes() == whole
