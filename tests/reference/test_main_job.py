"""The main job: the shipped scene worn until 60 um at the control point."""

import numpy as np
import pytest

import semiwear as sw
from semiwear.results import check_tree
from semiwear.results.missing import away_from_edges

pytestmark = pytest.mark.slow

KINDS = {
    "wear": (
        "wear_depth_max_root",
        "wear_depth_max_addendum",
        "wear_depth_max_pitch",
        "wear_depth_control_point",
    ),
    "pressure": ("contact_pressure_root", "contact_pressure_addendum", "contact_pressure_pitch"),
    "load share": ("load_share_max",),
    "root stress": ("root_stress_max",),
    "transmission error": ("transmission_error_mean", "transmission_error_amplitude"),
    "meshes": ("meshes",),
}


def test_thirteen_entries_at_the_control_depths(worn):
    assert worn["history"].sizes["wear_step"] == 13
    depth = worn["history"].wear_depth_control_point.values
    np.testing.assert_allclose(depth, 5.0 * np.arange(13), atol=0.01)


def test_meshes_grow_and_the_last_step_needs_more_than_the_first(worn):
    steps = np.diff(worn["history"].meshes.values)
    assert worn["history"].meshes.values[0] == 0.0
    assert steps.min() > 0.0
    assert steps[-1] > steps[0]


COURSES = {
    "load_share_max": +1,
    "contact_pressure_root": -1,
    "contact_pressure_addendum": -1,
    "contact_pressure_pitch": +1,
    "transmission_error_mean": +1,
    "transmission_error_amplitude": +1,
}


def test_wear_loads_one_pair_and_the_pitch_cone_and_enlarges_the_transmission_error(worn):
    history = worn["history"]
    for name, sign in COURSES.items():
        size = np.abs(history[name].values)
        assert sign * (size[-1] - size[0]) > 0.0, name
    assert float(history.load_share_max.max()) <= 1.0
    assert (history.transmission_error_mean.values < 0.0).all()
    assert (history.transmission_error_amplitude.values >= 0.0).all()
    assert float(np.abs(worn["flank"].wear_depth.sel(body="pinion")).max()) == 0.0


def test_wear_at_the_pitch_cone_is_least(worn):
    history = worn["history"].isel(wear_step=slice(1, None))
    assert (history.wear_depth_max_pitch < history.wear_depth_max_root).all()
    assert (history.wear_depth_max_pitch < history.wear_depth_max_addendum).all()


def test_all_values_are_finite_or_say_why_not(worn):
    for group in worn.subtree:
        for name, values in group.dataset.variables.items():
            if values.dtype.kind == "f" and not np.isfinite(values.values).all():
                where = f"{group.path}/{name}"
                assert not np.isinf(values.values).any(), where
                assert values.attrs["missing_because"], where
    # where the tips press alone there is no contact width, everywhere else there is
    engagement = worn["engagement"].to_dataset()
    missing = engagement.sliding_distance.isnull().any("body")
    assert (engagement.contact_pressure_on_edge.where(missing, 1) == 1).all()
    assert 0.0 < float(missing.mean()) < 0.2


def test_pressures_and_wear_are_not_negative(worn):
    for group, name in (
        ("flank", "wear_depth"),
        ("engagement", "contact_pressure_max"),
        ("engagement", "contact_pressure_max_edge"),
        ("engagement", "line_load"),
        ("engagement", "load_share"),
        ("engagement", "sliding_distance"),
        ("engagement", "root_stress"),
        *(("history", name) for kind in ("wear", "pressure") for name in KINDS[kind]),
    ):
        assert float(worn[group][name].min()) >= 0.0, name


def test_history_agrees_with_the_maps_and_the_engagement(worn):
    history, flank = worn["history"], worn["flank"]
    gear = flank.wear_depth.sel(body="gear")
    greatest = np.max([history[f"wear_depth_max_{zone}"] for zone in ("root", "pitch", "addendum")], axis=0)
    np.testing.assert_allclose(greatest, gear.max(("profile", "face")), rtol=1e-9)
    pressure = np.max([history[name] for name in KINDS["pressure"]], axis=0)
    inside = away_from_edges(worn["engagement"].to_dataset())
    np.testing.assert_allclose(pressure, inside.max("roll_position"), rtol=1e-9)
    np.testing.assert_allclose(history.load_share_max, worn["engagement"].load_share.max("roll_position"), rtol=1e-12)
    error = worn["mesh_cycle"].transmission_error_loaded
    np.testing.assert_allclose(history.transmission_error_mean, error.mean("mesh_position"), rtol=1e-12)


def test_saved_and_opened_again_is_identical(worn, tmp_path):
    check_tree(worn)
    sw.save(worn, tmp_path / "worn.nc")
    opened = sw.open_results(tmp_path / "worn.nc")
    assert opened.identical(worn)


def test_the_same_run_gives_the_same_result(shipped, worn):
    again = sw.simulate(shipped)
    for group in ("flank", "engagement", "mesh_cycle", "history"):
        assert again[group].dataset.equals(worn[group].dataset), group


@pytest.fixture(scope="module")
def finer(shipped):
    numerics = shipped.numerics
    return sw.simulate(
        shipped.replace(
            {
                "numerics.roll_positions": 2 * numerics.roll_positions,
                "numerics.face_slices": 2 * numerics.face_slices,
            }
        )
    )


@pytest.mark.parametrize("kind", KINDS)
def test_history_on_grids_twice_as_fine(worn, finer, kind):
    scale = max(float(np.abs(finer["history"][name]).max()) for name in KINDS[kind])
    for name in KINDS[kind]:
        change = np.abs(worn["history"][name].values - finer["history"][name].values)
        assert change.max() < 0.02 * scale, f"{name}: {100.0 * change.max() / scale:.2f} % at {change.argmax()}"
