"""Tips that press are seen: in the picture, in words, and with the relief that frees them."""

import numpy as np
import pytest

import semiwear as sw
from semiwear import plot
from semiwear.cli import main
from semiwear.results.pressing_tips import pressing_tips
from tests.strategies.results import synthetic_tree

QUICK = {"numerics.face_slices": 21, "numerics.wear_steps": 1, "wear.until.meshes": 1e6}
SPUR = sw.load_scene("spur_fzg_c").replace(QUICK)
FACE_GEAR = sw.load_scene("face_gear_25x160").replace(QUICK | {"wear.control_point": None})
BODIES = ("pinion", "gear")


def relieved(scene, relief):
    return scene.replace(
        {f"effects.modification.{body}.tip_relief_um": float(um) for body, um in zip(BODIES, relief, strict=True)}
    )


def shares(tree):
    """Greatest share of the load at each tip, unworn."""
    return tree["engagement"].tip_load_share.values[0].max(axis=0)


@pytest.fixture(scope="module")
def pressed():
    return sw.simulate(SPUR)


@pytest.mark.slow
@pytest.mark.parametrize("scene", [SPUR, FACE_GEAR], ids=["spur", "face gear"])
def test_the_relief_that_is_told_frees_the_tips(scene):
    """Half of it does not; all of it leaves less than a tenth on the spur pair.

    On the face gear, whose lines run obliquely into the tip, the relief takes load off the flank beside it as well:
    less than a third is left.
    """
    tree = sw.simulate(scene)
    relief = tree["history"].tip_relief_to_free.values[0]
    assert (relief > 5.0).all()
    before, half, whole = (shares(sw.simulate(relieved(scene, part * relief))) for part in (0.0, 0.5, 1.0))
    np.testing.assert_allclose(before, shares(tree), rtol=1e-12)
    assert (before > 0.1).all()
    assert (half > 0.3 * before).all()
    assert (whole < (0.1 if scene is SPUR else 1.0 / 3.0) * before).all()


def test_the_relief_is_the_deflection_of_the_pairs_that_bear(pressed):
    """At roll -0.71 the other pair alone bears the load without the tip: the relief is its approach, nearly."""
    error = pressed["mesh_cycle"].transmission_error_loaded.values[0]
    base_radius = 0.5 * 4.5 * 24 * np.cos(np.radians(20.0))
    approach = 1e3 * base_radius * np.radians(np.abs(error).max() / 3600.0)
    relief = pressed["history"].tip_relief_to_free.values[0]
    assert (relief > 0.7 * approach).all()
    assert (relief < 1.2 * approach).all()


def test_what_presses_is_told_in_words(pressed):
    texts = pressing_tips(pressed)
    assert len(texts) == 4
    relief = pressed["history"].tip_relief_to_free.values[0]
    assert texts[1].startswith("Unworn, the gear's tip edge is in contact at roll −0.71. Its slices carry up to ")
    told = " um of tip relief (effects.modification.gear.tip_relief_um) would relieve most of it"
    assert f"; about {relief[1]:.2g}{told}" in texts[1]
    free = pressed.copy(deep=True)
    free["engagement"].tip_load_share[:] = 0.0
    assert pressing_tips(free) == []


def test_relief_is_more_only_where_some_is_there_or_wear_has_taken_some(pressed):
    told = pressing_tips(pressed)
    assert [" um more of tip relief" in text for text in told] == [False, False, True, True]
    given = pressed.copy(deep=True)
    scene = SPUR.replace({"effects.modification.gear.tip_relief_um": 10.0})
    given.attrs["scene_toml"] = scene.to_toml()
    assert [" um more of tip relief" in text for text in pressing_tips(given)] == [False, True, True, True]


@pytest.mark.slow
def test_run_and_report_say_it(tmp_path, capsys, unseen):
    scene = tmp_path / "scene.toml"
    scene.write_text(SPUR.to_toml(), encoding="utf-8")
    assert main(["run", str(scene), "--report", str(tmp_path / "a.html")]) == 0
    assert "the gear's tip edge is in contact at roll −0.71" in capsys.readouterr().out
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert "Advice: tip edges in contact" in page
    assert "tip edge is in contact at roll −0.71" in page


def test_the_picture_hatches_where_edges_alone_bear(pressed):
    ax = plot.contact_pressure_over_engagement(pressed)
    hatched = [patch for patch in ax.patches if patch.get_hatch()]
    engagement = pressed["engagement"].to_dataset()
    alone = engagement.roll_position.values[(engagement.contact_pressure_on_edge.values == 1).any(axis=0)]
    spans = [(patch.get_x(), patch.get_x() + patch.get_width()) for patch in hatched]
    assert len(spans) == 2
    assert all(any(low <= roll <= high for low, high in spans) for roll in alone)
    curves = [line for line in ax.get_lines() if line.get_linestyle() == "-"]
    for line in curves:
        values = np.asarray(line.get_ydata())
        assert np.isnan(values[np.isin(line.get_xdata(), alone)]).any()
    dotted = np.concatenate([line.get_ydata() for line in ax.get_lines() if line.get_linestyle() == ":"])
    assert np.nanmax(dotted) == engagement.contact_pressure_max_edge.values.max()


def test_a_picture_without_pressing_edges_has_no_hatches():
    tree = synthetic_tree()
    tree["engagement"].contact_pressure_max_edge[:] = 0.0
    ax = plot.contact_pressure_over_engagement(tree)
    assert not ax.patches
