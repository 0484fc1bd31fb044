"""Figures of a crowd hold what they are given, odd windows too."""

import numpy as np
import pytest
from PIL import Image

from tendon_cli.figures.population import Bars, Group, draw_for_whom, draw_how_sure


def colours_of(path):
    with Image.open(path) as image:
        return np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0)


def has(path, colour):
    wanted = np.array([int(colour[at : at + 2], 16) for at in (1, 3, 5)])
    return bool((np.abs(colours_of(path).astype(int) - wanted).max(axis=1) < 12).any())


def test_served_and_others_are_told_apart(tmp_path):
    low = np.array([100.0, 110.0, 150.0, 90.0, np.nan])
    high = np.array([130.0, np.inf, 170.0, 80.0, np.nan])
    served = np.array([True, True, False, False, False])
    bodies = (np.linspace(60.0, 90.0, 5), np.linspace(300.0, 380.0, 5))
    groups = [Group("needs $more$", np.array([2])), Group("none", np.array([3, 4]))]
    whole = draw_for_whom(
        tmp_path / "a.png", "five $persons$", low, high, served, (110.0, 130.0), 120.0, bodies, ("kg", "mm"), groups
    )
    assert has(whole, "#0072b2")
    assert has(whole, "#d55e00")
    nobody = draw_for_whom(
        tmp_path / "b.png", "nobody", low, high, np.zeros(5, dtype=bool), (np.nan, np.nan), np.nan, kind="draws"
    )
    assert not has(nobody, "#0072b2")


def test_of_those_who_have_no_window_of_any_kind_the_number_is_told(tmp_path):
    nowhere = np.full(3, np.nan)
    no = np.zeros(3, dtype=bool)
    path = draw_for_whom(tmp_path / "n.png", "none", nowhere, nowhere, no, (np.nan, np.nan), np.nan)
    assert path.stat().st_size > 5_000


@pytest.mark.parametrize("count", [0, 1, 40])
def test_a_curve_of_any_length_is_drawn(tmp_path, count):
    place = np.repeat(np.linspace(100.0, 140.0, count), 2)
    share = np.linspace(0.0, 1.0, 2 * count)
    bars = Bars("lower end", np.array([0.3, 0.6]), np.array([0.02, 0.02]), np.array([0.4, 0.7]), np.array([0.1, 0.1]))
    path = draw_how_sure(
        tmp_path / "c.png", "curve", place, share, share * 0.9, share, 120.0, 0.95, ("μ", "K"), [bars, bars]
    )
    assert has(path, "#56b4e9")
