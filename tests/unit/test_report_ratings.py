"""The report's section on failure modes, and its pictures."""

import re

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from semiwear import plot
from semiwear.errors import SemiwearError
from semiwear.report.ratings import first_failure_text, ratings_section
from tests.strategies.results import synthetic_tree, without


@pytest.fixture(scope="module")
def tree():
    return synthetic_tree(5, profiles=9, faces=7)


def test_the_section_says_what_ends_the_life(tree, unseen):
    section = ratings_section(tree)
    assert "Pitting of the pinion ends the life first: after " in section and " h)" in section
    assert section.count("<img ") == 1 + 2  # the life, and a map of each mode
    rows = re.findall(r"<tr><th scope=\"row\">(pitting|bending)</th><td>(pinion|gear)</td>", section)
    assert rows == [(mode, body) for mode in ("pitting", "bending") for body in ("pinion", "gear")]
    assert "height −2.00 mm, face 508.0 mm" in section
    assert "safety 0.020, life " in section


def test_a_result_without_ratings_has_no_section(tree):
    assert ratings_section(without(tree, "ratings")) == ""


def test_without_a_failure_the_section_says_so():
    ratings = synthetic_tree(1, profiles=9, faces=7)["ratings"].to_dataset()
    assert first_failure_text(ratings) == (
        "None of the rated failure modes (pitting, bending) falls below its required safety within this run."
    )


def test_the_mode_that_governs_is_shaded_and_the_limit_is_in_view(tree):
    ax = plot.safety_history(tree)
    assert ax.get_ylim()[0] < 1.0 < ax.get_ylim()[1]
    assert ax.get_xlabel() == "Running time (h)"
    # pitting has the least of both all the time: one stretch, in its colour
    (stretch,) = ax.patches
    assert stretch.get_facecolor()[:3] == pytest.approx(to_rgb(ax.lines[0].get_color()))


@pytest.mark.parametrize("summed", [True, False])
def test_safeties_cross_the_limit_where_the_sentence_says_that_the_life_ends(tree, summed):
    """Damage that adds up is far beyond its end at the first wear step: a line from static strength crosses late."""
    ratings = tree["ratings"].to_dataset().isel(wear_step=[0, 3, 4]).copy(deep=True)
    at = ratings["hours"].values
    end = 0.02 * at[1] if summed else float(ratings["hours_to_failure"][0, 0])
    ratings["hours_to_failure"][0, 0] = end
    if not summed:
        ratings = ratings.drop_vars("damage_sum")
    copy = tree.copy()
    copy["ratings"] = type(tree)(ratings)
    ax = plot.safety_history(copy)
    curve, cross = ax.lines[0], ax.lines[2]
    assert curve.get_label() == "pitting, pinion" and cross.get_xdata()[0] == pytest.approx(end)
    places, values = curve.get_data()
    assert np.interp([*at, end], places, values) == pytest.approx([*ratings["safety"][0, :, 0].values, 1.0], rel=1e-9)
    assert np.all(values[places < 0.999 * end] > 1.0) and np.all(values[places > 1.001 * end] < 1.0)
    if summed:  # straight between logarithms
        middle = np.sqrt(end * at[1])
        assert np.interp(middle, places, values) == pytest.approx(values[places == at[1]][0] ** 0.5, rel=1e-3)


def test_a_life_without_wear_is_drawn():
    plot.safety_history(synthetic_tree(1, profiles=9, faces=7))


def test_without_a_speed_the_life_is_in_meshes(tree):
    assert "meshes" in plot.safety_history(without(tree, "ratings", "hours")).get_xlabel()


def test_maps_show_both_bodies_and_refuse_a_mode_that_is_not_rated(tree):
    pinion, gear = plot.safety_map(tree, mode="bending")
    assert pinion.get_title(loc="left").startswith("Pinion") and gear.get_title(loc="left").startswith("Gear")
    with pytest.raises(SemiwearError, match="mode: 'wear'; this result has pitting, bending"):
        plot.safety_map(tree, mode="wear")
