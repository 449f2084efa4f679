"""Names beside curves: where their curves end, clear of one another, in their order."""

import matplotlib.pyplot as plt
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from semiwear import plot
from semiwear.plot.curve_names import _apart, name_curves, name_place
from tests.strategies.results import synthetic_tree


@given(st.lists(st.floats(0.0, 1.0), min_size=1, max_size=8), st.floats(0.01, 0.1))
def test_names_keep_clear_of_one_another_in_the_order_of_their_ends(wanted, room):
    wanted, rooms = np.array(wanted), np.full(len(wanted), room)
    at = _apart(wanted, rooms)
    order = np.argsort(wanted, kind="stable")
    assert (np.diff(at[order]) >= room - 1e-9).all()
    assert at.max() <= 1.0 + 0.5 * room + 1e-9
    if (np.diff(wanted[order]) >= room).all():
        np.testing.assert_allclose(at, wanted)


def test_a_name_stands_at_the_end_of_its_curve():
    _, ax = plt.subplots()
    for end, name in ((1.0, "low"), (9.0, "high"), (5.0, "middle")):
        ax.plot([0.0, 1.0], [3.0, end], label=name)
    ax.set_ylim(0.0, 10.0)
    name_curves(ax)
    assert {text.get_text(): pytest.approx(text.get_position()[1]) for text in ax.texts} == {
        "low": 0.1,
        "middle": 0.5,
        "high": 0.9,
    }


def test_curves_that_end_together_are_named_in_the_order_of_their_means():
    _, ax = plt.subplots()
    x = np.linspace(0.0, 1.0, 21)
    for height, name in ((2.0, "b"), (1.0, "a"), (3.0, "c")):
        ax.plot(x, height * x * (1.0 - x), label=name)
    name_curves(ax)
    names = sorted(ax.texts, key=lambda text: text.get_position()[1])
    assert [text.get_text() for text in names] == ["a", "b", "c"]


@pytest.mark.parametrize("body", ["pinion", "gear"])
def test_sections_run_through_the_deepest_place(body):
    tree = synthetic_tree(3)
    wear = tree["flank"]["wear_depth"].sel(body=body).values[-1]
    for panel in plot.wear_profiles(tree, body=body):
        thick = max(panel.get_lines(), key=lambda line: line.get_linewidth())
        assert np.nanmax(thick.get_ydata()) == pytest.approx(wear.max(), rel=1e-12)
        assert len(panel.get_lines()) <= 4


@pytest.mark.parametrize("height", [0.0, 0.5, 1.0])
def test_the_name_of_a_place_at_a_border_lies_within_the_axes(height):
    figure, ax = plt.subplots()
    ax.set(xlim=(0.0, 1.0), ylim=(0.0, 1.0))
    name_place(ax, 0.0, height, "greatest wear")
    figure.canvas.draw()
    lies, frame = ax.texts[0].get_window_extent(), ax.get_window_extent()
    assert frame.y0 - 2.0 <= lies.y0 and lies.y1 <= frame.y1 + 2.0
