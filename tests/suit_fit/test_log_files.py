"""Logs as loggers write them: the same numbers, or refused with the true cause."""

import numpy as np
import pytest

import tendon_cli as tendon
from tendon_cli.errors import InputError
from tendon_cli.fits.suit.suit_log import read_logs
from tendon_cli.studies.fit_section import Fitting, LogColumns
from tests.readers.files import Written, good, hostile

TIMES = 0.05 * np.arange(80)
ANGLES = 45.0 - 44.0 * np.cos(2.0 * np.pi * TIMES / 4.0)
ROWS = [
    [f"{time:.2f}", f"{angle:.3f}", f"{2.0 * angle - 30.0:.3f}"]
    for time, angle in zip(TIMES, ANGLES, strict=True)
]
LOG = Written(("time", "elbow_angle", "spool_angle"), ("s", "deg", "deg"), ROWS)
GOOD = good(LOG)
HOSTILE = hostile(LOG, 1)


@pytest.fixture
def read(tmp_path):
    """Return a function that reads a log of some content."""

    def log_of(content, named=None):
        path = tmp_path / "log.csv"
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        (log,) = read_logs([path], Fitting(columns=LogColumns(**(named or {}))))
        return log

    return log_of


@pytest.mark.parametrize("way", GOOD)
def test_a_log_is_the_same_however_it_is_written(way, read):
    log = read(GOOD[way])
    assert np.allclose(log.elbow_angle, np.radians(ANGLES), atol=1e-5)
    assert np.allclose(log.channels["spool_angle"], np.radians(2.0 * ANGLES - 30.0), atol=2e-5)
    assert np.allclose(log.time, TIMES)


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_log_is_refused_with_its_place(name, read):
    content, where, message = HOSTILE[name]
    with pytest.raises(InputError) as caught:
        read(content)
    assert message in caught.value.message
    assert where in f"{caught.value.where}"


def test_columns_by_their_numbers(read):
    bare = LOG.of_lines(("Enc1", "A", "B"))
    named = {"elbow_angle": "2", "spool_angle": "3", "time": "1"}
    for text in (bare, bare.partition("\n")[2]):
        with pytest.raises(InputError, match="has no unit"):
            read(text, named)
    units = LOG.of_lines(("Enc1", "A", "B"), ("s", "deg", "deg"))
    assert np.allclose(read(units, named).elbow_angle, np.radians(ANGLES), atol=1e-5)


def test_an_encoder_that_wraps_is_counted_on(read):
    turns = [[row[0], row[1], f"{(5.0 * float(row[1])) % 360.0:.3f}"] for row in ROWS]
    log = read(Written(LOG.names, LOG.units, turns).text())
    assert np.allclose(log.channels["spool_angle"], np.radians(5.0 * ANGLES), atol=1e-4)
    assert any("starts again after one turn" in note for note in log.notes)


def test_a_logger_that_restarts_names_the_line(read):
    twice = LOG.text() + LOG.text().partition("\n")[2]
    with pytest.raises(InputError, match="time starts again in this row") as caught:
        read(twice)
    assert caught.value.where == "log.csv, line 82"


def test_tables_of_tendon_are_logs(tmp_path):
    """A frame has its units beside it, an export in its headers."""
    states = tendon.sweep({"load": {"mass": "3 kg"}}).states
    units = states.attrs["units"]
    exported = states.rename(columns=lambda name: f"{name} ({units[name]})")
    exported.to_csv(tmp_path / "states.csv", index=False)
    for source in (states, tmp_path / "states.csv"):
        (log,) = read_logs([source], Fitting())
        assert log.load_mass[0] == 3.0
        assert np.isin(log.elbow_angle, states["elbow_angle"]).all()
        assert np.isin(log.channels["motor_torque"], states["motor_torque"]).all()
        assert len(log.channels) == 6


def test_millis_is_a_time(read):
    text = LOG.text().replace("time (s)", "millis").replace(".", "")
    text = "\n".join([text.splitlines()[0], *LOG.text().splitlines()[1:]])
    assert read(text).time[-1] == pytest.approx(TIMES[-1] / 1000.0)
