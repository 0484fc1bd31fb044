"""A fragment of μφ: taken with the bend angle that stands beside it."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import tendon_cli as tendon
from tendon_cli.errors import StudyError

TABLE = Path(__file__).parents[2] / "configs" / "friction" / "table_a1.csv"


def test_a_product_is_taken_with_its_bend(tmp_path: Path) -> None:
    from tendon_cli.friction import write_fragment

    fit = tendon.fit_friction(TABLE)
    write_fragment(fit, tmp_path / "f.toml")
    study = tmp_path / "study.toml"
    study.write_text('[sheath]\nfriction_from = "f.toml"\nbend_angle = "144 deg"\n')
    known = tendon.fit_friction(TABLE, "144 deg")
    assert tendon.load_study(study).sheath.friction.single == pytest.approx(known.friction, rel=1e-12)
    assert fit.friction_bend == pytest.approx(known.friction * math.radians(144.0), rel=1e-12)
    for bend in ('bend_angle = ["144 deg", "180 deg"]\n', ""):
        study.write_text(f'[sheath]\nfriction_from = "f.toml"\n{bend}')
        with pytest.raises(StudyError, match=r"one sheath\.bend_angle"):
            tendon.load_study(study)
