"""The tables of the paper's studies, each swept once."""

from __future__ import annotations

import shutil

import pytest

from tendon_cli import cli
from tendon_cli.tables.read import open_table


@pytest.fixture(scope="session")
def figure(configs, tmp_path_factory):
    """The states and the designs of a study of the paper, as `tendon sweep` writes them."""
    folder, swept = tmp_path_factory.mktemp("paper"), {}

    def tables(name):
        if name not in swept:
            study, out = folder / f"{name}.toml", folder / name
            shutil.copy(configs / "paper" / f"{name}.toml", study)
            with pytest.raises(SystemExit) as end:
                cli.main(["sweep", str(study), "--no-figures", "--quiet", "--out", str(out)])
            assert end.value.code == 0
            swept[name] = [open_table(out / f"{table}.parquet").read().to_pandas() for table in ("states", "designs")]
        return swept[name]

    return tables
