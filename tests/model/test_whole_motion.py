"""Tops of parabolas through the values at three angles."""

import numpy as np
import pytest

from tendon_cli.model.power_window import widest
from tendon_cli.model.whole_motion import _parabola_top

PLACES = np.array([-1.0, 0.0, 1.0])


def test_the_top_of_a_parabola_is_its_vertex_where_it_lies_between_the_angles():
    random = np.random.default_rng(1)
    vertex = random.uniform(-0.95, 0.95, 200)
    height = random.normal(size=200)
    curvature = -random.uniform(0.1, 10.0, 200)
    values = height[:, np.newaxis] + curvature[:, np.newaxis] * np.square(
        PLACES - vertex[:, np.newaxis]
    )
    offset, top = _parabola_top(values)
    assert offset == pytest.approx(vertex, abs=1e-9)
    assert top == pytest.approx(height, abs=1e-9)


@pytest.mark.parametrize(
    ("values", "place"),
    [
        ([1.0, 2.0, 3.0], 1.0),
        ([3.0, 2.0, 1.0], -1.0),
        ([3.0, 1.0, 2.0], -1.0),
        ([-9.0, -4.0, -1.0], 1.0),
    ],
    ids=["a line", "a falling line", "a valley", "a vertex outside"],
)
def test_elsewhere_the_largest_value_is_the_top(values, place):
    offset, top = _parabola_top(np.array([values]))
    assert offset.item() == place
    assert top.item() == max(values)


def test_the_most_samples_in_a_row_are_found_wherever_they_stand():
    every = [f"{pattern:06b}" for pattern in range(64)]
    kept = np.array([[sign == "1" for sign in pattern] for pattern in every])
    for pattern, first, last in zip(every, *widest(kept), strict=True):
        most = max(pattern.split("0"), key=len)
        if not most:
            assert first == last == -1
            continue
        assert last - first + 1 == len(most)
        assert pattern[first : last + 1] == most
