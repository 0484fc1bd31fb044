"""Results of another version are told which tendon reads them."""

import pytest

from tendon_cli.version import reader_of


@pytest.mark.parametrize(
    ("version", "reader"),
    [(4, "tendon 0.1.0"), (6, "tendon 0.3.0"), (98, "an earlier tendon"), (100, "a later tendon")],
)
def test_who_reads_results_of_another_version(monkeypatch, version, reader):
    monkeypatch.setattr("tendon_cli.version.RESULTS_VERSION", 99)
    assert reader_of(version) == reader
