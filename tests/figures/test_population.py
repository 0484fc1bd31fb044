"""Figures of persons and draws hold what they are given, odd windows too."""

import numpy as np
import pytest
from PIL import Image

from tendon_cli.figures.served import for_whom, how_sure
from tendon_cli.figures.style import house_style


def colours(page, path):
    with house_style():
        page.save(path)
    with Image.open(path) as image:
        return np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0)


def has(found, colour):
    wanted = np.array([int(colour[at : at + 2], 16) for at in (1, 3, 5)])
    return bool((np.abs(found.astype(int) - wanted).max(axis=1) < 12).any())


def record(read="pretension", **population):
    nothing = {
        "title": "t",
        "kind": "persons",
        "pretension": None,
        "window": [None, None],
        "not_served": [],
    }
    return {
        "serve": 0.95,
        "study": {"setting": {"read": read}},
        "population": {**nothing, "sobol": [], **population},
    }


def reason(text, needs, low, high):
    bodies = {"weight": {"deviations": 1.0}, "stature": {"deviations": 2.0}}
    return {"text": text, "needs": needs, "limits": [low, high], "share": 0.2, "bodies": bodies}


def test_served_and_others_have_their_colours(tmp_path):
    rows = {
        "pretension_from": np.array([100.0, 110.0, 150.0, 90.0, np.nan]),
        "pretension_to": np.array([130.0, np.nan, 170.0, 80.0, np.nan]),
        "served": np.array([1.0, 1.0, 0.0, 0.0, 0.0]),
        "from_by": np.array(["a", "a", "a", "b", "b"], dtype=object),
        "to_by": np.array(["c", "", "c", "c", ""], dtype=object),
        "weight": np.linspace(60.0, 90.0, 5),
        "stature": np.linspace(1.6, 1.9, 5),
    }
    reasons = [reason("needs $more$", "more", "a", "c"), reason("none", "another suit", "b", "c")]
    whole = colours(
        for_whom(record(window=[110.0, 130.0], pretension=120.0, not_served=reasons), rows),
        tmp_path / "a.png",
    )
    assert has(whole, "#0072b2")
    assert has(whole, "#d55e00")
    of_draws = {name: rows[name] for name in ("pretension_from", "pretension_to")} | {
        "served": np.zeros(5)
    }
    assert not has(colours(for_whom(record(kind="draws"), of_draws), tmp_path / "b.png"), "#0072b2")


def test_where_nobody_has_a_window_it_is_drawn(tmp_path):
    nowhere = np.full(3, np.nan)
    page = for_whom(
        record(), {"pretension_from": nowhere, "pretension_to": nowhere, "served": np.zeros(3)}
    )
    assert len(colours(page, tmp_path / "n.png")) > 5


@pytest.mark.parametrize("count", [0, 1, 40])
def test_a_curve_of_any_length_is_drawn(tmp_path, count):
    share = np.linspace(0.0, 1.0, 2 * count)
    curve = {
        "pretension": np.repeat(np.linspace(100.0, 140.0, count), 2),
        "share": share,
        "low": share * 0.9,
    }
    each = {"first": 0.3, "first_standard_error": 0.02, "total": 0.4, "total_standard_error": 0.1}
    ends = [
        {
            "end": end,
            "standard_deviation": 2.0,
            "inputs": {"a": {"name": "μ", **each}, "b": {"name": "K", **each}},
        }
        for end in ("pretension_from", "pretension_to")
    ]
    page = how_sure(record(curve={**curve, "high": share}, pretension=120.0, sobol=ends))
    assert has(colours(page, tmp_path / "c.png"), "#56b4e9")


@pytest.mark.parametrize(
    ("read", "label"),
    [
        ("pretension", "pretension F₀ (N)"),
        ("extensor at motor", "tension in the extensor at the motor (N)"),
    ],
)
def test_axes_name_what_is_read(read, label):
    rows = {
        "pretension_from": np.array([90.0, 95.0]),
        "pretension_to": np.full(2, 130.0),
        "served": np.ones(2),
    }
    ends = {name: np.array([90.0, 130.0]) for name in ("pretension", "share", "low", "high")}
    asked = record(read, curve=ends, pretension=120.0)
    with house_style():
        of_whom, of_sure = for_whom(asked, rows).figure.axes[0], how_sure(asked).figure.axes[0]
    assert (of_whom.get_ylabel(), of_sure.get_xlabel()) == (label, label)
    assert f"the least {label.split()[0]} they need" in of_whom.get_xlabel()
