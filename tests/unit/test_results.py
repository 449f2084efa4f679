import hashlib
import platform
from importlib import metadata

import netCDF4
import numpy as np
import pytest
import xarray as xr

import semiwear as sw
from semiwear.errors import SemiwearError
from semiwear.results import (
    COORDINATES,
    GROUPS,
    VARIABLES,
    Zone,
    build_dataset,
    build_tree,
    check_tree,
    open_results,
    provenance,
    save,
)
from semiwear.results.schema import coordinates_of, variables_of
from semiwear.simulate import attributes
from tests.strategies.results import synthetic_tree, without

TREE = synthetic_tree(3, profiles=5, faces=4, mesh_positions=4)


def parts(tree=TREE):
    """Groups and coords of a tree as plain arrays, the input of `build_tree`."""
    groups = {
        group: {str(name): array.values for name, array in tree[group].to_dataset().data_vars.items()}
        for group in tree.children
    }
    coords = {
        str(name): array.values for group in tree.children for name, array in tree[group].to_dataset().coords.items()
    }
    return groups, coords, {}


# ---------------------------------------------------------------------- schema


def test_every_entry_has_units_long_name_and_source():
    for entry in [*VARIABLES.values(), *COORDINATES.values()]:
        assert entry.units and entry.long_name and entry.references, entry.name
        assert all(dim in COORDINATES for dim in entry.dims)


def test_flags_of_the_table_are_the_zones():
    assert VARIABLES["flank", "zone"].flags == tuple(zone.name.lower() for zone in Zone)


def test_names_of_the_design_are_there():
    names = {
        "flank": "flank_height flank_radius zone active specific_sliding surface_error wear_depth contact_pattern",
        "engagement": "load_share contact_pressure_max contact_pressure_on_edge contact_pressure_max_edge "
        "tip_load_share line_load line_length lever_arm sliding_distance "
        "root_stress friction_coefficient friction_power_loss friction_torque_loss "
        "flash_temperature_max film_thickness_min",
        "mesh_cycle": "transmission_error_loaded transmission_error_unloaded pairs_in_contact",
        "history": "wear_depth_max_root wear_depth_max_addendum wear_depth_max_pitch wear_depth_max "
        "wear_depth_max_pinion_root wear_depth_max_pinion_pitch wear_depth_max_pinion_addendum "
        "wear_depth_control_point wear_depth_max_pinion wear_volume wear_volume_on_edges load_share_max "
        "root_stress_max contact_pressure_root contact_pressure_addendum contact_pressure_pitch "
        "tip_relief_to_free subsurface_stress_max subsurface_stress_depth "
        "transmission_error_mean transmission_error_amplitude mesh_efficiency friction_power_loss_mean "
        "contact_temperature_max lambda_ratio_min",
        "life": "depth_limit meshes_to_limit hours_to_limit meshes_to_end hours_to_end ended_by "
        "sensitivity_to_wear_coefficient sensitivity_to_torque",
        "ratings": "required_safety safety safety_error safety_height safety_face damage_sum safety_on_flank "
        "meshes_to_failure meshes_to_failure_exponent meshes_to_failure_error hours_to_failure "
        "wear_step_of_failure fails_first hours",
        "diagnostics": "iterations load_balance_residual complementarity_residual edge_residual wear_law_residual "
        "wear_volume_residual elements_across reaches_border edge_contact smallest_gap usual_step_depth seconds "
        "effect_seconds error_estimate",
        "tooth_contact": "path_of_contact transmission_error principal_relative_curvature "
        "contact_ellipse_angle contact_ratio undercut_radius pointing_radius",
    }
    assert tuple(names) == GROUPS
    for group, expected in names.items():
        assert [entry.name for entry in variables_of(group)] == expected.split()


def test_every_variable_of_a_tree_is_in_the_schema_and_carries_it():
    for group in TREE.children:
        for name, array in TREE[group].to_dataset().variables.items():
            entry = VARIABLES.get((group, name)) or COORDINATES[name]
            assert array.dims == entry.dims
            assert array.attrs["units"] == entry.units
            assert array.attrs["long_name"] == entry.long_name
            assert array.attrs["references"] == entry.references


def test_root_carries_attributes_alone():
    assert not TREE.to_dataset().variables
    assert TREE.attrs["schema_version"] == "1"
    assert all(isinstance(value, str) for value in TREE.attrs.values())


def test_meshes_go_with_wear_step():
    for group in ("flank", "engagement", "mesh_cycle", "history", "diagnostics"):
        assert "meshes" in coordinates_of(group)
        assert TREE[group]["meshes"].dims == ("wear_step",)


def test_zone_flags():
    assert TREE["flank/zone"].attrs["flag_meanings"].split() == ["root", "pitch", "addendum"]
    assert list(TREE["flank/zone"].attrs["flag_values"]) == [Zone.ROOT, Zone.PITCH, Zone.ADDENDUM]


# ---------------------------------------------------------------------- building


NOT_FINITE = [
    (bad, entry.path)
    for bad in (np.nan, np.inf, -np.inf)
    for entry in VARIABLES.values()
    if entry.group in TREE.children and entry.dtype != "str" and not (entry.absent and np.isnan(bad))
    if not (entry.infinite and bad == np.inf)
]


@pytest.mark.parametrize(("bad", "path"), NOT_FINITE)
def test_a_value_that_is_not_finite_is_refused_by_name(path, bad):
    _, group, name = path.split("/")
    groups, coords, _ = parts()
    array = groups[group][name].astype(float)
    array[(-1,) * array.ndim] = bad
    groups[group][name] = array
    with pytest.raises(SemiwearError, match=f"{path}: 1 of {array.size} values are not finite"):
        build_dataset(group, groups[group], coords)


@pytest.mark.parametrize("name", ["face", "meshes", "roll_position", "mesh_position"])
def test_a_coordinate_that_is_not_finite_is_refused_by_name(name):
    groups, coords, attrs = parts()
    coords[name] = np.full(coords[name].shape, np.nan)
    with pytest.raises(SemiwearError, match=f"coordinate {name}"):
        build_tree(groups, coords, attrs)


def put(part, name, change):
    """A change of one group or of the coordinates (`part` ""); None takes away."""

    def changed(groups, coords, attrs):
        owner = groups[part] if part else coords
        value = change(owner.get(name)) if callable(change) else change
        owner.pop(name, None)
        if value is not None:
            owner[name] = value

    return changed


WRONG = {
    "another length": (
        put("engagement", "load_share", lambda values: values[:, :-1]),
        r"/engagement/load_share: shape .* \(wear_step, roll_position\)",
    ),
    "other dimensions": (put("history", "load_share_max", np.array(0.8)), "/history/load_share_max"),
    "an unknown variable": (put("history", "load", np.zeros(3)), "/history/load"),
    "an unknown group": (lambda groups, coords, attrs: groups.update(histories={}), "/histories"),
    "an unknown coordinate": (put("", "radius", np.zeros(3)), "coordinate radius"),
    "a missing coordinate": (
        put("", "roll_position", None),
        "roll_position: missing, needed by /engagement/load_share",
    ),
    "other bodies": (put("", "body", np.array(["gear", "pinion"])), "coordinate body"),
    "an unknown flag": (put("flank", "zone", lambda zone: zone + 1), r"/flank/zone: values must be 0 \(root\)"),
    "no text": (lambda groups, coords, attrs: attrs.update(converged=True), "attribute converged"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_contradicts_the_schema_is_refused_by_name(name):
    change, words = WRONG[name]
    groups, coords, attrs = parts()
    change(groups, coords, attrs)
    with pytest.raises(SemiwearError, match=words):
        build_tree(groups, coords, attrs)


def test_a_coordinate_is_no_variable():
    groups, coords, _ = parts()
    with pytest.raises(SemiwearError, match="give it as a coordinate"):
        build_dataset("history", {**groups["history"], "meshes": np.zeros(3)}, coords)


def test_a_required_variable_is_missed_and_an_optional_one_is_not():
    groups, coords, attrs = parts()
    del groups["engagement"]["root_stress"], groups["history"]["root_stress_max"]
    tree = build_tree(groups, coords, attrs)
    assert "root_stress" not in tree["engagement"].to_dataset()
    del groups["engagement"]["load_share"]
    with pytest.raises(SemiwearError, match="/engagement: load_share missing"):
        build_tree(groups, coords, attrs)


def test_history_needs_meshes_and_loaded_contact_does_not():
    groups, coords, attrs = parts()
    del coords["meshes"]
    with pytest.raises(SemiwearError, match="meshes"):
        build_tree(groups, coords, attrs)
    del groups["history"]
    build_tree(groups, coords, attrs)


def test_arrays_are_copied():
    groups, coords, attrs = parts()
    tree = build_tree(groups, coords, attrs)
    groups["history"]["load_share_max"][:] = 0.0
    assert (tree["history/load_share_max"].values > 0).all()


def test_tooth_contact_dataset():
    roll = np.linspace(-1, 1, 5)
    dataset = build_dataset(
        "tooth_contact",
        {
            "path_of_contact": np.zeros((5, 3)),
            "transmission_error": np.zeros(5),
            "principal_relative_curvature": np.ones((5, 2)),
            "contact_ellipse_angle": np.zeros(5),
            "contact_ratio": 1.554,
            "undercut_radius": 465.17,
        },
        {"roll_position": roll},
        {"title": "tooth contact analysis"},
    )
    assert list(dataset["axis"].values) == ["x", "y", "z"]
    assert list(dataset["direction"].values) == ["along", "across"]
    assert float(dataset["contact_ratio"]) == 1.554
    assert dataset["principal_relative_curvature"].attrs["units"] == "1/mm"
    assert "pointing_radius" not in dataset


# ---------------------------------------------------------------------- files


def test_save_and_open_is_identical(tmp_path):
    save(TREE, tmp_path / "worn.nc")
    opened = open_results(tmp_path / "worn.nc")
    assert [entry.name for entry in tmp_path.iterdir()] == ["worn.nc"]
    (tmp_path / "worn.nc").unlink()  # which it does not hold
    assert opened.identical(TREE)
    for group in TREE.children:
        for name, array in TREE[group].to_dataset().variables.items():
            assert opened[group][name].dtype == array.dtype


def test_other_readers_open_the_file(tmp_path):
    save(TREE, tmp_path / "worn.nc")
    with netCDF4.Dataset(tmp_path / "worn.nc") as opened:
        packing = opened["flank/wear_depth"].filters()
        assert packing["zlib"] and packing["shuffle"] and packing["complevel"] == 1


def test_a_failing_write_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "worn.nc"
    save(TREE, path)
    before = path.read_bytes()

    def fail(self, target, **_):
        target.write_bytes(b"half of it")
        raise OSError("disk full")

    monkeypatch.setattr(xr.DataTree, "to_netcdf", fail)
    with pytest.raises(OSError, match="disk full"):
        save(synthetic_tree(2), path)
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["worn.nc"]


def test_save_refuses_what_is_no_result(tmp_path):
    with pytest.raises(SemiwearError, match="schema_version"):
        save(xr.DataTree(), tmp_path / "worn.nc")
    tree = without(TREE, "engagement", "load_share")
    with pytest.raises(SemiwearError, match="/engagement/load_share: missing"):
        check_tree(tree)
    tree = TREE.copy(deep=True)
    tree["history/load_share_max"].values[0] = np.nan
    with pytest.raises(SemiwearError, match="/history/load_share_max"):
        save(tree, tmp_path / "worn.nc")
    with pytest.raises(FileNotFoundError, match="nowhere"):
        save(TREE, tmp_path / "nowhere" / "worn.nc")
    assert not list(tmp_path.iterdir())


def test_variables_of_the_user_are_kept(tmp_path):
    tree = TREE.copy(deep=True)
    tree["history/mine"] = xr.DataArray(np.arange(3.0), dims="wear_step")
    save(tree, tmp_path / "worn.nc")
    assert open_results(tmp_path / "worn.nc").identical(tree)


# ---------------------------------------------------------------------- provenance and imports


def test_provenance():
    attrs = provenance(title="t", scene_toml="a = 1", physics="p", fidelity="line", references="r")
    assert attrs["accuracy"] == "not asked for"
    assert attrs["scene_sha256"] == hashlib.sha256(b"a = 1").hexdigest()
    assert attrs["history"].endswith("simulate") and attrs["source"].startswith("semiwear")
    assert attrs["input_files"] == "none"


def test_provenance_names_libraries_platform_and_the_files_that_were_read(tmp_path):
    path = tmp_path / "gear.csv"
    path.write_text("um,0,0.3,0.6,1\n" + "".join(f"{k / 3},0,0,0,0\n" for k in range(4)), encoding="utf-8")
    change = {"title": str(path), "effects.modification.gear.file": str(path), "numerics.face_slices": 11}
    scene = sw.load_scene("face_gear_25x160").replace(change | {"numerics.tooth_compliance": "rigid"})
    wanted = f"{path}: sha256 {hashlib.sha256(path.read_bytes()).hexdigest()}"
    physics = sw.plan(scene)
    physics.loaded_teeth()
    path.unlink()  # what counts is what was read
    attrs = attributes(physics, "simulate")
    assert attrs["input_files"] == wanted
    for name in ("numpy", "scipy", "numba"):
        assert f"{name} {metadata.version(name)}" in attrs["libraries"]
    assert platform.python_version() in attrs["platform"] and platform.system() in attrs["platform"]
