"""Every notebook of the pages runs; what it prints is not kept, so that few draws judge it."""

import json
from pathlib import Path

import matplotlib as mpl
import pytest
from matplotlib import pyplot as plt

NOTEBOOKS = sorted((Path(__file__).parents[2] / "docs" / "notebooks").glob("*.ipynb"))


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda notebook: notebook.stem)
def test_a_notebook_runs_from_its_first_cell_to_its_last(notebook, workplace, monkeypatch):
    monkeypatch.setattr(plt, "show", plt.close)
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    session = {"__name__": "__main__"}
    with mpl.rc_context({"backend": "agg"}):
        for cell in code:
            exec(cell, session)  # noqa: S102 - our own pages
    assert code
