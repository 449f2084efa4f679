"""Values that a result does not have are missing for a reason that is told, and edges are told apart."""

import numpy as np
import pytest
import xarray as xr

import semiwear as sw
from semiwear import collect, plot
from semiwear.commands.wear_table import wear_table
from semiwear.contact.loads import SlicePressures
from semiwear.plan import plan
from semiwear.report.pictures import PICTURES, draw
from semiwear.report.sections import wear_steps
from semiwear.results import build_dataset, build_tree
from semiwear.results.kinds import difference, step_errors
from semiwear.results.missing import away_from_edges, missing_notes, why_missing
from tests.strategies.results import synthetic_tree

SPUR = sw.load_scene("spur_fzg_c").replace({"numerics.face_slices": 21, "numerics.tooth_compliance": "rigid"})


@pytest.fixture(scope="module")
def spur():
    """Rigid teeth, of which only tips touch before and after the path of contact."""
    return sw.loaded_contact(SPUR.replace({"operation.pinion_torque_Nm": 1500}))


def test_a_pair_that_bears_on_an_edge_alone_has_the_edges_pressure(spur):
    engagement = spur["engagement"].to_dataset()
    bears = engagement.load_share.values > 1e-6
    on_edge = engagement.contact_pressure_on_edge.values == 1
    pressure, edge = engagement.contact_pressure_max.values, engagement.contact_pressure_max_edge.values
    assert (on_edge & bears).any()
    assert (pressure[bears] > 0.0).all()
    np.testing.assert_array_equal(pressure[on_edge], edge[on_edge])
    clean = away_from_edges(engagement).values
    assert np.isnan(clean[on_edge]).all()
    np.testing.assert_array_equal(clean[~on_edge], pressure[~on_edge])
    assert np.isnan(engagement.sliding_distance.values[on_edge]).all()
    assert "edges alone" in why_missing(engagement.sliding_distance)


def test_zones_without_a_roll_position_are_missing_with_a_reason():
    teeth = plan(SPUR).loaded_teeth()
    state = teeth.load(np.zeros(teeth.grid.profile.shape), None, np.zeros(teeth.driving.grid.profile.shape))
    found = teeth.pressures(state)
    only_root = found.place < teeth.pair.pitch_profile(teeth.grid.face) - 4.0 * teeth.half_width
    pressure = SlicePressures(np.where(only_root, found.inner, 0.0), found.place, found.border)
    parts = {"engagement": {"load_share": np.ones(1)}, "mesh_cycle": {"transmission_error_loaded": np.zeros(2)}}
    history = collect.history(teeth, state, pressure, parts)
    assert history["contact_pressure_root"] == pytest.approx(pressure.inner.max(), rel=0.05)
    assert np.isnan(history["contact_pressure_pitch"])
    assert np.isnan(history["contact_pressure_addendum"])


@pytest.fixture(scope="module")
def without_pitch():
    """A result whose pitch zone is never met, and half of its root zone."""
    tree = synthetic_tree()
    groups = {name: {str(n): a.values for n, a in tree[name].data_vars.items()} for name in tree.children}
    coords = {str(n): c.values for name in tree.children for n, c in tree[name].to_dataset().coords.items()}
    groups["history"]["contact_pressure_pitch"] = np.full(13, np.nan)
    groups["history"]["contact_pressure_root"] = np.where(np.arange(13) < 6, np.nan, 900.0)
    groups["engagement"]["sliding_distance"] = np.full_like(groups["engagement"]["sliding_distance"], np.nan)
    attrs = {k: v for k, v in tree.attrs.items() if k != "schema_version"}
    return build_tree(groups, coords, attrs)


def test_missing_values_say_why_and_outlive_a_file(without_pitch, tmp_path):
    sw.save(without_pitch, tmp_path / "a.nc")
    again = sw.open_results(tmp_path / "a.nc")
    notes = missing_notes(again["history"].to_dataset())
    assert set(notes) == {"contact_pressure_pitch", "contact_pressure_root"}
    assert "pitch band" in notes["contact_pressure_pitch"]
    assert "missing_because" not in again["history"].contact_pressure_addendum.attrs


def test_lives_without_end_are_infinite_say_why_and_outlive_a_file(without_pitch, tmp_path):
    life = {"depth_limit": 8.0, "meshes_to_limit": np.inf, "hours_to_limit": np.inf}
    life |= {"sensitivity_to_wear_coefficient": np.nan, "sensitivity_to_torque": np.nan}
    tree = without_pitch.copy()
    tree["life"] = xr.DataTree(build_dataset("life", life, {}))
    sw.save(tree, tmp_path / "a.nc")
    again = sw.open_results(tmp_path / "a.nc")["life"]
    assert again.meshes_to_limit == again.hours_to_limit == np.inf
    assert "no wear ends its life" in again.meshes_to_limit.attrs["infinite_because"]
    for name, wrong in (("meshes_to_limit", np.nan), ("hours_to_limit", -np.inf), ("depth_limit", np.inf)):
        with pytest.raises(sw.SemiwearError, match=f"{name}: 1 of 1 values are not finite"):
            build_dataset("life", life | {name: wrong}, {})


@pytest.mark.slow
def test_table_report_and_pictures_cope_and_say_why(without_pitch, tmp_path, unseen):
    table = wear_table(without_pitch)
    assert "nan" not in table
    assert "- p pitch [MPa]: no roll position has its greatest pressure within the pitch band" in table
    assert "contact pressure pitch: no roll position" in wear_steps(without_pitch)
    names = {"contact_stress_history", "sliding_along_path", "contact_pressure_over_engagement", "contact_pattern"}
    drawn = {one.name: draw(one, without_pitch) for one in PICTURES if one.name in names}
    assert "none (no roll position" in drawn["contact_stress_history"].alt
    assert "edges alone" in drawn["sliding_along_path"].alt
    names = plot.contact_stress_history(without_pitch).texts
    assert "pitch cone (none clear of edges)" in [text.get_text() for text in names]
    page = sw.report(without_pitch, tmp_path / "a.html", synthetic_tree(9)).read_text(encoding="utf-8")
    assert "is missing at some wear steps" in page
    assert ">nan<" not in page.lower()


def test_error_estimates_leave_out_what_is_missing():
    one = {"contact_pressure_pitch": np.array([np.nan, 2.0]), "contact_pressure_root": np.array([np.nan, np.nan])}
    two = {"contact_pressure_pitch": np.array([1.0, 4.0]), "contact_pressure_root": np.array([np.nan, 1.0])}
    assert difference(one, two) == {"contact_pressure_pitch": 0.5}
    assert step_errors(0.1, one) == {}
    assert step_errors(0.1, two) == {"contact_pressure_pitch": pytest.approx(0.1 * 3.0 / 4.0)}
