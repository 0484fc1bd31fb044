"""Figures of persons and draws hold what they are given, odd windows too."""

from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from tendon_cli.figures.served import for_whom, how_sure
from tendon_cli.figures.style import house_style


def colours(page, path):
    """Save a page as an image and return the colours of its pixels (colours, 3)."""
    with house_style():
        page.save(path)
    with Image.open(path) as image:
        return np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0)


def has(pixels, colour):
    """Return True if a colour, written as in CSS, is nearly that of a pixel."""
    red, green, blue = bytes.fromhex(colour.removeprefix("#"))
    differences = np.abs(pixels.astype(int) - np.array([red, green, blue]))
    return bool((differences.max(axis=1) < 12).any())


def record(read="pretension", **population):
    """Return the record of a population for whom nothing is known unless it is given."""
    unknown = {
        "title": "t",
        "kind": "persons",
        "pretension": None,
        "window": [None, None],
        "not_served": [],
        "sobol": [],
    }
    return SimpleNamespace(
        name="suit",
        study_hash="0" * 64,
        serve=0.95,
        best=None,
        question=SimpleNamespace(unit="N", read=read, setting_digits=4, shows_own_f0=False),
        population=SimpleNamespace(**{**unknown, **population}),
    )


def reason(text, needs, low, high):
    """Return the record of why a fifth of the persons is not served."""
    bodies = {
        name: SimpleNamespace(deviations=deviations)
        for name, deviations in (("weight", 1.0), ("stature", 2.0))
    }
    return SimpleNamespace(text=text, needs=needs, limits=[low, high], share=0.2, bodies=bodies)


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
    of_persons = record(window=[110.0, 130.0], pretension=120.0, not_served=reasons)
    pixels = colours(for_whom(of_persons, rows), tmp_path / "a.png")
    assert has(pixels, "#56b4e9")
    assert has(pixels, "#d55e00")
    nobody_served = {
        "pretension_from": rows["pretension_from"],
        "pretension_to": rows["pretension_to"],
        "served": np.zeros(5),
    }
    pixels = colours(for_whom(record(kind="draws"), nobody_served), tmp_path / "b.png")
    assert not has(pixels, "#0072b2")


def test_where_nobody_has_a_window_it_is_drawn(tmp_path):
    nothing = np.full(3, np.nan)
    rows = {"pretension_from": nothing, "pretension_to": nothing, "served": np.zeros(3)}
    page = for_whom(record(), rows)
    assert len(colours(page, tmp_path / "n.png")) > 5


@pytest.mark.parametrize("count", [0, 1, 40])
def test_a_curve_of_any_length_is_drawn(tmp_path, count):
    share = np.linspace(0.0, 1.0, 2 * count)
    curve = {
        "pretension": np.repeat(np.linspace(100.0, 140.0, count), 2),
        "share": share,
        "low": share * 0.9,
        "high": share,
    }
    index = {"first": 0.3, "first_standard_error": 0.02, "total": 0.4, "total_standard_error": 0.1}
    inputs = {key: SimpleNamespace(name=name, **index) for key, name in (("a", "μ"), ("b", "K"))}
    sobol = [
        SimpleNamespace(end=end, standard_deviation=2.0, inputs=inputs)
        for end in ("pretension_from", "pretension_to")
    ]
    page = how_sure(record(curve=SimpleNamespace(**curve), pretension=120.0, sobol=sobol))
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
    curve = {name: np.array([90.0, 130.0]) for name in ("pretension", "share", "low", "high")}
    population = record(read, curve=SimpleNamespace(**curve), pretension=120.0)
    with house_style():
        persons = for_whom(population, rows).figure.axes[0]
        shares = how_sure(population).figure.axes[0]
    assert persons.get_ylabel() == label
    assert shares.get_xlabel() == label
    assert f"the least {label.split()[0]}" in persons.get_xlabel()
    assert "they need" in persons.get_xlabel()
