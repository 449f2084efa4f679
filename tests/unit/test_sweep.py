"""Sweeps: what is refused at once, what a dataset holds, what is shared, what a store spares; solving is made up."""

import json
import os
import time
from dataclasses import replace
from importlib import import_module
from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import semiwear as sw
from semiwear.check import geometric_problems
from semiwear.errors import ConvergenceError, EndlessWearError, ResultFileError, SceneError
from semiwear.plan import Compared
from semiwear.plot.sweeps import scene_values
from semiwear.results import VARIABLES
from semiwear.scene.schema import SCHEMAS
from semiwear.scene.units import UNITS, unit_of
from semiwear.sweep.files import open_sweep, write_sweep
from semiwear.sweep.measure import MESHES, Measure, Measured, measure_of, read_off
from semiwear.sweep.names import short_names
from semiwear.sweep.scenes import Task, geometry_of, scenes_of, shared_by
from semiwear.sweep.shares import Shares
from semiwear.sweep.store import open_store
from semiwear.sweep.variation import read_variation
from tests.scenes import SHIPPED, TINY, UNTIL_MESHES, Heard
from tests.strategies.ratings import RATED
from tests.strategies.results import synthetic_tree

outcome = import_module("semiwear.sweep.outcome")
SCENE = SHIPPED.replace({**TINY, "wear.until.control_depths_um": [2, 4]})
TORQUE, OFFSET = "operation.pinion_torque_Nm", "effects.misalignment.offset_mm"
K, DEPTHS = "wear.coefficient_mm2_per_N", "wear.until.control_depths_um"
REFUSED = {"gear_pair.gear_inner_radius_mm": 440.0}  # undercut


@pytest.fixture
def solved(monkeypatch):
    """Scenes that were solved: each by a formula of its torque, offset and coefficient, some of them not."""
    scenes: list[sw.Scene] = []

    def simulate(scene):
        scenes.append(scene)
        torque = scene.operation.pinion_torque_Nm
        if torque == 1300.0:
            raise ConvergenceError("load sharing stopped")
        if torque == 1301.0:
            raise ZeroDivisionError("by nothing")
        wear, misaligned = scene.wear, scene.effects.misalignment
        steps = len(wear.until.control_depths_um or (1, 2, 3)) + 1
        tree = synthetic_tree(steps, profiles=scene.numerics.profile_points // 10, faces=3, mesh_positions=3)
        history = tree["history"].to_dataset()
        history["root_stress_max"] = history["root_stress_max"] * torque + (misaligned.offset_mm if misaligned else 0)
        meshes = history["meshes"] * (1e-13 / wear.coefficient("gear"))
        tree["history"] = xr.DataTree(history.assign_coords(meshes=meshes))
        return tree

    monkeypatch.setattr(outcome, "simulate", simulate)
    monkeypatch.setattr(outcome, "simulate_as_given", lambda scene, **_: outcome.simulate(scene))
    return scenes


def sweep(vary, **options):
    return sw.sweep(options.pop("scene", SCENE), vary, workers=0, **options)


def same(one: xr.Dataset, other: xr.Dataset) -> bool:
    """Equal to the last bit, but for the time that it took."""
    one, other = one.drop_vars("seconds"), other.drop_vars("seconds")
    bits = all(one[name].values.tobytes() == other[name].values.tobytes() for name in one.variables)
    return one.identical(other) and bits


# ---------------------------------------------------------------------- refused before anything runs


def problems_of(vary, **options) -> str:
    with pytest.raises(SceneError) as error:
        sweep(vary, **options)
    return str(error.value)


def test_every_problem_is_told_at_once(solved):
    told = problems_of(
        {
            "operation.torque_Nm": [1],
            TORQUE: [800, -5, "much"],
            OFFSET: [],
            "effects.friction": [None, {"coeficient": 0.1}],
            "gear_pair.module_mm": 6.35,
            "material.gear.name": ["a", "a"],
        },
        measure=["histori"],
        wear_states="first",
    )
    for part in (
        "did you mean pinion_torque_Nm?", "entry 2 of 3: give its size", "entry 3 of 3", "an empty list",
        "effects.friction.coeficient", "did you mean coefficient?", "give [6.35]", "entry 2 repeats entry 1",
        "did you mean history?", "wear_states: found 'first'",
    ):  # fmt: skip
        assert part in told
    assert not solved


@pytest.mark.parametrize(
    "vary, options, part",
    [
        ({}, {}, "one or more fields"),
        ("torque", {}, "a mapping"),
        ({TORQUE: "800"}, {}, "give ['800']"),
        ({TORQUE: [1, 2], OFFSET: [0.1]}, {"combine": "zip"}, f"{TORQUE}: 2, {OFFSET}: 1"),
        ({TORQUE: [1]}, {"combine": "all"}, '"grid" or "zip"'),
        ({TORQUE: [1]}, {"measure": []}, "one or more names"),
        ({TORQUE: [np.nan]}, {}, "finite"),
        ({TORQUE: [None]}, {}, "every scene needs a value"),
        ({"effects.misalignment": [None], OFFSET: [0.1]}, {}, "varied together with its table"),
        ({TORQUE: [1]}, {"scene": SCENE.replace({"wear": None})}, "a table [wear]"),
        (pd.DataFrame({TORQUE: [800, np.nan, 900]}), {}, "row 1: give a value"),
        (pd.DataFrame({TORQUE: []}), {}, "no rows"),
        (pd.DataFrame({"torque": [1.0]}), {}, "did you mean"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named(solved, vary, options, part):
    assert part in problems_of(vary, **options)
    assert not solved


@pytest.mark.parametrize("workers", [-1, 2.5, True, "all"])
def test_workers_are_a_number(workers):
    with pytest.raises(SceneError, match="workers"):
        sw.sweep(SCENE, {TORQUE: [1]}, workers=workers)


def test_many_problems_are_counted():
    assert "5 more problems" in problems_of({TORQUE: [-float(k) for k in range(1, 26)]})


def test_every_scene_illegal_is_an_error(solved):
    told = problems_of({"gear_pair.gear_inner_radius_mm": [440.0, 441.0]})
    assert "sweep, every scene" in told and "undercut" in told
    assert not solved


# ---------------------------------------------------------------------- the dataset


def test_a_grid_has_a_dimension_for_each_field(solved):
    found = sweep({TORQUE: [800, 1600, 1200], OFFSET: [0.0, 0.1]})
    assert dict(found.sizes) == {"pinion_torque_Nm": 3, "offset_mm": 2, "wear_step": 3, "body": 2}
    assert found.pinion_torque_Nm.attrs["field"] == TORQUE and found.pinion_torque_Nm.attrs["units"] == "N m"
    assert found.offset_mm.attrs["units"] == "mm" and found.offset_mm.attrs["long_name"]
    stress = found["root_stress_max"]
    assert stress.dims == ("pinion_torque_Nm", "offset_mm", "wear_step", "body") and stress.attrs["units"] == "MPa"
    one = stress.sel(pinion_torque_Nm=1600, offset_mm=0.0) / stress.sel(pinion_torque_Nm=800, offset_mm=0.0)
    np.testing.assert_allclose(one, 2.0)
    assert (found["status"] == 0).all() and (found["message"] == "").all() and (found["seconds"] >= 0).all()
    for name in found.data_vars:
        assert {"units", "long_name"} <= found[name].attrs.keys()


def test_lists_side_by_side_and_tables_have_samples(solved):
    side = sweep({TORQUE: [800, 1600], OFFSET: [0.0, 0.1]}, combine="zip")
    table = sweep(pd.DataFrame({TORQUE: [800, 1600], OFFSET: [0.0, 0.1]}, index=["light", "heavy"]))
    assert side["load_share_max"].dims == table["load_share_max"].dims == ("sample", "wear_step")
    assert list(table["sample"].values) == ["light", "heavy"] and list(side["sample"].values) == [0, 1]
    np.testing.assert_array_equal(side["root_stress_max"], table["root_stress_max"])
    np.testing.assert_array_equal(table["offset_mm"], [0.0, 0.1])


def test_values_may_be_text_tables_and_whole_numbers(solved):
    found = sweep(
        {
            "operation.loaded_flank": ["drive", "coast"],
            "effects.friction": [None, {}, {"law": "constant", "coefficient": 0.08}],
            "gear_pair.gear_teeth": [160, 158],
            "material.gear": [{"name": "bronze", "youngs_modulus_MPa": 110000}],
        }
    )
    assert list(found["loaded_flank"].values) == ["drive", "coast"]
    assert list(found["friction"].values) == ["none", "{}", '{law = "constant", coefficient = 0.08}']
    assert found["gear_teeth"].dtype.kind == "i" and found["gear_teeth"].attrs["units"] == "1"
    assert {scene.material.gear.youngs_modulus_MPa for scene in solved} == {110000.0}
    assert found.status.isel(gear_teeth=0).values.max() == 0


def test_a_scene_that_fails_is_missing_and_stops_nothing(solved):
    found = sweep({TORQUE: [800, 1300, 1301], "gear_pair.gear_inner_radius_mm": [480.0, 440.0]})
    meanings = found["status"].attrs["flag_meanings"].split()
    told = [[meanings[value] for value in row] for row in found["status"].values]
    assert told == [["done", "refused"], ["failed", "refused"], ["failed", "refused"]]
    reasons = found["message"].values[:, 0]
    assert list(reasons) == ["", "load sharing stopped", "ZeroDivisionError: by nothing"]
    assert "undercut" in str(found["message"].values[0, 1])
    for name in ("load_share_max", "root_stress_max", "meshes"):
        missing = np.isnan(found[name]).all([dim for dim in found[name].dims if dim not in found["status"].dims])
        np.testing.assert_array_equal(missing, found["status"] != 0)
        assert "the scene failed" in found[name].attrs["missing_because"]


def test_a_run_that_stops_midway_keeps_what_it_has(solved, monkeypatch):
    simulate = outcome.simulate

    def stops(scene):
        tree = simulate(scene)
        if scene.operation.pinion_torque_Nm > 1000:
            raise ConvergenceError("stopped at 2e8 meshes", tree.isel(wear_step=slice(0, 2)))
        return tree

    monkeypatch.setattr(outcome, "simulate", stops)
    found = sweep({TORQUE: [800, 1600]})
    assert list(found["status"].values) == [0, 2] and "stopped at" in str(found["message"].values[1])
    assert list(found["last_wear_step"].values) == [2, 1]
    kept = np.isfinite(found["load_share_max"].values)
    np.testing.assert_array_equal(kept, [[True, True, True], [True, True, False]])
    assert list(np.isfinite(scene_values(found, "load_share_max"))) == [True, False]  # it has no end
    last = sweep({TORQUE: [800, 1600]}, wear_states="last")
    assert list(np.isfinite(last["load_share_max"].values)) == [True, False]


def test_what_is_measured_is_asked_for(solved):
    found = sweep({TORQUE: [800, 1600]}, measure=["/flank/wear_depth", "mesh_cycle"], wear_states="last")
    assert found["wear_depth"].dims == ("pinion_torque_Nm", "body", "profile", "face")
    assert found["transmission_error_loaded"].dims == ("pinion_torque_Nm", "mesh_position")
    assert "load_share_max" not in found and "face" in found.coords and found["meshes"].dims == ("pinion_torque_Nm",)


def test_runs_of_other_lengths_and_grids_are_filled_up_with_a_reason(solved):
    found = sweep(
        {DEPTHS: [[2, 4], [1, 2, 3]], "numerics.profile_points": [31, 41]}, measure=["history", "wear_depth"]
    )
    assert found.sizes["wear_step"] == 4 and found.sizes["profile"] == 4
    assert list(found["last_wear_step"].values[:, 0]) == [2, 3]
    last = found["load_share_max"].isel(wear_step=found["last_wear_step"])
    assert np.isfinite(last).all() and not np.isfinite(found["load_share_max"]).all()
    assert "more wear steps" in found["load_share_max"].attrs["missing_because"]
    assert list(found["control_depths_um"].values) == ["[2.0, 4.0]", "[1.0, 2.0, 3.0]"]


def test_shorter_runs_alone_are_a_reason_and_the_only_one(solved):
    found = sweep({DEPTHS: [[2, 4], [1, 2, 3]]}, measure="load_share_max")
    assert found["load_share_max"].attrs["missing_because"] == "other scenes have more wear steps or a finer grid"


def test_names_are_as_short_as_can_be_told_apart():
    keys = ("material.pinion.poissons_ratio", "material.gear.poissons_ratio", "wear.until.meshes", TORQUE)
    assert list(short_names(keys).values()) == [
        "pinion_poissons_ratio", "gear_poissons_ratio", "until_meshes", "pinion_torque_Nm",
    ]  # fmt: skip


def test_units_are_those_that_the_allowed_ranges_name():
    words = {"mm^2/N": "mm2/N", "degC": "degrees Celsius", "deg": "degrees", "rpm": "rev/min", "1/GPa": "per GPa"}
    words |= {"mrad/(kN m)": "mrad/kNm", "kg/m^3": "kg/m3"}
    rules = {key: rule for schema in SCHEMAS.values() for key, rule in schema.rules.items()}
    met = set()
    for key, rule in rules.items():
        unit = unit_of(key)
        if unit != "1" and "file" not in rule.allowed:
            met.add(unit)
            assert words.get(unit, unit) in rule.allowed or key == "effects.load_spectrum.torques_Nm", key
    assert met == set(UNITS.values())


# ---------------------------------------------------------------------- shared


def test_scenes_that_differ_in_the_coefficient_alone_are_solved_once(solved):
    found = sweep({K: [1e-13, 2e-13, 5e-14], TORQUE: [800, 1600]})
    assert len(solved) == 2
    meshes = found["meshes"].isel(wear_step=-1)
    np.testing.assert_allclose(meshes / meshes[0], np.array([1.0, 0.5, 2.0])[:, None] * [1.0, 1.0], rtol=1e-15)
    np.testing.assert_array_equal(found["root_stress_max"][1], found["root_stress_max"][0])


def test_a_number_of_meshes_is_worn_with_each_coefficient(solved):
    sweep({K: [1e-13, 2e-13]}, scene=SCENE.replace({**UNTIL_MESHES, "wear.until.meshes": 1e8}))
    assert [scene.wear.coefficient("gear") for scene in solved] == [1e-13, 2e-13]


def test_two_bodies_share_where_the_ratio_of_their_coefficients_is_the_same(solved):
    both = SCENE.replace({"wear.worn_bodies": ["pinion", "gear"], K: {"pinion": 1e-13, "gear": 2e-13}})
    values = [{"pinion": 1e-13, "gear": 2e-13}, {"pinion": 2e-13, "gear": 4e-13}, {"pinion": 1e-13, "gear": 1e-13}]
    found = sweep({K: values}, scene=both)
    assert len(solved) == 2
    assert float(found["meshes"][1, -1]) == 0.5 * float(found["meshes"][0, -1])


def test_checks_of_the_teeth_are_not_repeated_and_find_the_same():
    calls = []

    def check(scene):
        calls.append(scene)
        return geometric_problems(scene)

    base = replace(SCENE, _check=check)
    vary = {
        TORQUE: [1.0, 2.0, 3.0],
        "gear_pair.gear_inner_radius_mm": [480.0, 440.0],
        K: [1e-13, 1e-12],
        OFFSET: [0.1],
    }
    found = scenes_of(base, read_variation(base, vary, "grid"))
    assert len(calls) == 2
    for one, changes in zip(found, read_variation(base, vary, "grid").changes(), strict=True):
        try:
            assert SCENE.replace(changes) == one
        except SceneError as error:
            assert str(error) == str(one)


def test_workers_keep_to_scenes_that_share_their_lines():
    measure = measure_of(None, "all")
    scenes = [SCENE.replace({TORQUE: 1e3 + k, OFFSET: 0.01 * (k % 3)}) for k in range(12)]
    shares = Shares(Task(str(k), scene, measure) for k, scene in enumerate(scenes))
    taken = {worker: [] for worker in "ab"}
    for k in range(12):
        worker = "ab"[k % 2]
        taken[worker].append(geometry_of(shares.take(worker).scene)[1])
    assert shares.take("a") is None
    changes = {worker: sum(x != y for x, y in pairwise(own)) for worker, own in taken.items()}
    assert changes["a"] <= 1 and changes["b"] <= 1


def test_runs_on_one_course_of_prisms_stay_together():
    measure, width = measure_of(None, "all"), "gear_pair.pinion_face_width_mm"
    like, at = Compared.with_runs_of(SCENE), SCENE.gear_pair.pinion_face_width_mm
    beside = SCENE.replace({width: at + 0.01})
    tasks = [
        Task(str(k), SCENE.replace({width: at + 0.1 * k}), measure, like.along(SCENE, beside, 10.0 * k))
        for k in (-1, 1)
    ]
    assert shared_by(tasks[0]) == shared_by(tasks[1]) != shared_by(replace(tasks[0], compared=like))


# ---------------------------------------------------------------------- the store


def test_a_grown_sweep_computes_what_is_missing(solved, tmp_path):
    sweep({TORQUE: [800, 1300], OFFSET: [0.0]}, store=tmp_path / "kept")
    before = len(solved)
    grown = sweep({OFFSET: [0.1, 0.0], TORQUE: [1300, 800, 900]}, store=tmp_path / "kept")
    assert before == 2 and len(solved) == 6
    fresh = sweep({OFFSET: [0.1, 0.0], TORQUE: [1300, 800, 900]})
    assert same(grown, fresh)


def test_the_order_of_fields_does_not_matter(solved):
    one = sweep({TORQUE: [800, 1300], OFFSET: [0.0, 0.1]})
    other = sweep({OFFSET: [0.0, 0.1], TORQUE: [800, 1300]}).transpose(*one.dims)
    assert one.drop_vars("seconds").equals(other.drop_vars("seconds"))


def test_a_store_keeps_what_lasts_and_forgets_what_passes(solved, tmp_path):
    for _ in range(2):
        sweep({TORQUE: [800, 1300, 1301]}, store=tmp_path / "kept")
    torques = [scene.operation.pinion_torque_Nm for scene in solved]
    assert torques == [800.0, 1300.0, 1301.0, 1301.0]


def test_a_damaged_file_is_computed_anew(solved, tmp_path):
    first = sweep({TORQUE: [800, 900]}, store=tmp_path / "kept")
    files = sorted((tmp_path / "kept").glob("*.npz"))
    files[0].write_bytes(files[0].read_bytes()[:100])
    assert same(sweep({TORQUE: [800, 900]}, store=tmp_path / "kept"), first)
    assert len(solved) == 3


@pytest.mark.parametrize("change", ["version", "code", "foreign", "damaged", "file"])
def test_a_store_of_another_version_is_refused_before_anything_runs(solved, tmp_path, change):
    kept = tmp_path / "kept"
    if change == "file":
        kept.write_text("text")
    elif change == "foreign":
        kept.mkdir()
        (kept / "letter.txt").write_text("text")
    else:
        sweep({TORQUE: [800]}, store=kept)
        told = json.loads((kept / "sweep.json").read_text())
        if change == "version":
            told["store"] = 0
        else:
            told["versions"]["semiwear's code"] = "of old"
        (kept / "sweep.json").write_text("{" if change == "damaged" else json.dumps(told))
    solved.clear()
    with pytest.raises(ResultFileError, match=r"another version|not a store|damaged"):
        sweep({TORQUE: [800]}, store=kept)
    assert not solved


def test_other_measures_are_other_entries(solved, tmp_path):
    kept = tmp_path / "kept"
    sweep({TORQUE: [800]}, store=kept)
    found = sweep({TORQUE: [800]}, store=kept, measure="wear_depth")
    assert "wear_depth" in found and len(solved) == 2


# ---------------------------------------------------------------------- progress, files


def test_progress_counts_scenes(solved, tmp_path):
    heard = Heard()
    sweep({TORQUE: [800, 1300], K: [1e-13, 2e-13]}, progress=heard, store=tmp_path / "kept")
    assert heard.steps == [(0, 4, ""), (2, 4, ""), (4, 4, "2 failed")]
    again = Heard()
    sweep({TORQUE: [800, 1300], K: [1e-13, 2e-13]}, progress=again, store=tmp_path / "kept")
    assert again.steps == [(4, 4, "2 failed")]
    sweep({TORQUE: [800]}, progress=True)


@pytest.mark.parametrize("kind", ["nc", "zarr"])
def test_a_dataset_can_be_written_and_read(solved, tmp_path, kind):
    found = sweep({TORQUE: [800, 1300], "effects.friction": [None, {}]}, measure=["history", "wear_depth"])
    path = tmp_path / f"sweep.{kind}"
    for _ in range(2):  # the second time in place of the first
        write_sweep(found, path)
        back = open_sweep(path)
    for name in found.variables:
        assert back[name].dims == found[name].dims and back[name].attrs.keys() == found[name].attrs.keys()
        np.testing.assert_array_equal(back[name].values.astype(found[name].dtype), found[name].values)
    assert back.attrs == found.attrs and [path.name] == [entry.name for entry in tmp_path.iterdir()]


# ---------------------------------------------------------------------- what is measured


def test_every_quantity_of_history_and_life_is_measured_by_default():
    paths = measure_of(None, "all").variables
    assert set(paths) == {f"/{group}/{name}" for group, name in VARIABLES if group in ("history", "life")}


def test_names_are_those_of_groups_and_variables_in_the_order_of_the_schema():
    found = measure_of(("meshes_to_limit", "/history/wear_volume", "mesh_cycle", "wear_depth"), "last")
    wanted = ("wear_depth", "wear_volume", "meshes_to_limit")
    assert found.variables == tuple(
        f"/{group}/{name}" for group, name in VARIABLES if group == "mesh_cycle" or name in wanted
    )
    assert found.last and not measure_of("wear_depth", "all").last
    assert measure_of("wear_depth", "all").variables == ("/flank/wear_depth",)


def test_a_life_alone_is_all_or_nothing():
    assert measure_of("life", "all").life_alone
    assert not measure_of(["life", "wear_volume"], "all").life_alone


@pytest.mark.parametrize("name", ["tooth_contact", "pointing_radius"])
def test_another_analysis_is_not_measured(name):
    with pytest.raises(SceneError, match="measure"):
        measure_of(name, "all")


def test_all_that_is_wrong_with_a_measure_is_told():
    with pytest.raises(SceneError) as error:
        measure_of(["mesh_cycel", "wear_dept", 3], "first")
    for part in ("did you mean mesh_cycle?", "did you mean wear_depth?", "VARIABLES", "wear_states", '"last" for'):
        assert part in str(error.value)
    with pytest.raises(SceneError, match="one or more names"):
        measure_of([], "all")


@pytest.mark.parametrize("last", [False, True])
def test_numbers_and_coordinates_are_read_off_and_text_is_not(last):
    history = xr.Dataset(
        {"load_share_max": ("wear_step", [0.5, 0.6]), "root_stress_max": (("wear_step", "body"), [[1, 2], [3, 4]])},
        {"meshes": ("wear_step", [0.0, 7.0]), "body": ["pinion", "gear"], "wear_step": [0, 1]},
    )
    tree = xr.DataTree.from_dict(
        {"history": history, "life": xr.Dataset({"ended_by": "wear", "meshes_to_end": 7.0, "whole": True})}
    )
    paths = ("/history/load_share_max", "/history/root_stress_max", "/history/wear_volume", "/flank/wear_depth")
    found = read_off(tree, Measure((*paths, "/life/ended_by", "/life/meshes_to_end", "/life/whole"), last))
    pick = -1 if last else slice(None)
    expected = {
        paths[0]: [0.5, 0.6][pick], paths[1]: [[1, 2], [3, 4]][pick], "/life/meshes_to_end": 7.0, "/life/whole": True,
        MESHES: [0.0, 7.0][pick],
    }  # fmt: skip
    assert {path: values.tolist() for path, values in found.variables.items()} == expected
    assert {name: values.tolist() for name, values in found.coords.items()} == {"body": ["pinion", "gear"]}


# ---------------------------------------------------------------------- lives without end


@pytest.mark.parametrize("last", [False, True])
def test_a_life_without_end_is_infinite_and_the_run_is_told(solved, monkeypatch, last):
    known = outcome.simulate

    def simulate(scene):
        tree = known(scene)
        if scene.operation.pinion_torque_Nm < 1000.0:
            del tree["life"]
            raise EndlessWearError("the gear wears no further", tree, life=True)
        return tree

    monkeypatch.setattr(outcome, "simulate", simulate)
    found = sweep({TORQUE: [800, 1600]}, wear_states="last" if last else "all")
    assert found["status"].values.tolist() == [outcome.Status.ENDLESS, outcome.Status.DONE]
    assert str(found["message"].values[0]) == "the gear wears no further"
    assert np.isinf(found["meshes_to_limit"][0]) and np.isfinite(found["meshes_to_limit"][1])
    assert np.isfinite(scene_values(found, "root_stress_max")).all()


def test_no_failure_at_all_outlives_every_first_failure(solved, monkeypatch):
    """Wear stops, and no failure mode ends the life: it has no end. One that pitting ends has no end by wear."""
    path = "/life/meshes_to_"
    outcomes = {800.0: None, 1600.0: {f"{path}limit": np.inf, f"{path}end": 3e8}}

    def life(task):
        told = outcomes[task.scene.operation.pinion_torque_Nm]
        if told is None:
            raise EndlessWearError("the gear wears no further", life=True)
        return Measured({name: np.asarray(value) for name, value in told.items()})

    monkeypatch.setattr(outcome, "_life", life)
    scene = SCENE.replace({"effects.run_life": {"depth_limit_um": 4.0, "ends_at": "first_failure"}, **RATED})
    found = sw.sweep(scene, {TORQUE: [800, 1600]}, measure="life", workers=0)
    assert found["meshes_to_end"].values.tolist() == [np.inf, 3e8]
    assert np.isinf(found["meshes_to_limit"]).all()


@pytest.mark.parametrize("last", [False, True])
def test_a_run_without_end_has_infinite_meshes_where_its_end_is_measured(solved, monkeypatch, last):
    def simulate(scene):
        raise EndlessWearError("the control point wears no further")

    monkeypatch.setattr(outcome, "simulate", simulate)
    found = sweep({TORQUE: [800, 1600]}, wear_states="last" if last else "all", measure="history")
    assert (found["status"] == (outcome.Status.ENDLESS if last else outcome.Status.FAILED)).all()
    assert ("meshes" in found) == last
    assert not last or np.isinf(found["meshes"]).all()


# ---------------------------------------------------------------------- stores that several sweeps write to


def test_parts_that_another_sweep_is_writing_are_left(tmp_path):
    open_store(tmp_path / "store")
    fresh, left = (tmp_path / "store" / f"{name}.npz.part" for name in ("fresh", "left"))
    for part in (fresh, left):
        part.write_bytes(b"")
    os.utime(left, (0.0, time.time() - 4000.0))
    open_store(tmp_path / "store")
    assert fresh.exists() and not left.exists()


def test_a_part_that_was_removed_is_written_once_more(tmp_path, monkeypatch):
    store, replaced = open_store(tmp_path / "store"), []
    known = os.replace

    def replace_late(part, file):
        replaced.append(part)
        if len(replaced) == 1:
            os.unlink(part)
        known(part, file)

    monkeypatch.setattr(os, "replace", replace_late)
    store.put(outcome.Outcome("key", outcome.Status.REFUSED, "no"))
    assert len(replaced) == 2 and store.get("key").message == "no"


def test_files_with_deviations_are_looked_at_for_every_scene(tmp_path):
    file = tmp_path / "deviations.csv"
    file.write_text("nothing of the kind")
    base, key = replace(SCENE, _check=geometric_problems), "effects.modification.gear"
    scenes = scenes_of(base, read_variation(base, {key: [None, {"file": str(file)}]}, "grid"))
    assert isinstance(scenes[0], sw.Scene) and isinstance(scenes[1], SceneError)
