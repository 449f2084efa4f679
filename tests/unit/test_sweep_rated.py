"""Sweeps of scenes whose failure modes are rated: the numbers of runs of single scenes, for every coefficient."""

from dataclasses import replace

import numpy as np
import pytest

import semiwear as sw
from semiwear.simulate import simulate as simulate_as_given
from semiwear.sweep.assemble import assembled
from semiwear.sweep.measure import Measured, measure_of
from semiwear.sweep.outcome import Outcome, Status
from semiwear.sweep.scenes import Member, shared_solution
from semiwear.sweep.store import MemoryStore
from semiwear.sweep.variation import read_variation
from tests.scenes import TINY
from tests.strategies.ratings import RATED

K, TORQUE = "wear.coefficient_mm2_per_N", "operation.pinion_torque_Nm"
SCENE = sw.load_scene("spur_fzg_c").replace(
    RATED | TINY | {TORQUE: 200.0, "numerics.wear_steps": 1, "wear.until.meshes": 1e7}
)
DEPTHS = SCENE.replace(
    {"wear.control_point": {"face_mm": 0.0, "height_mm": 2.0}, "wear.until.control_depths_um": [2.0]}
)
LIFE = {"depth_limit_um": 4.0, "ends_at": "first_failure"}


def test_what_is_measured_by_default_is_that_of_single_runs():
    found = sw.sweep(SCENE, {TORQUE: [200.0]}, workers=0).isel(pinion_torque_Nm=0)
    assert not str(found["message"].values)
    history = sw.simulate(SCENE)["history"]
    np.testing.assert_array_equal(found["root_stress_max"].values, history["root_stress_max"].values)


def test_groups_that_are_asked_for_bring_no_others():
    told = SCENE.replace({"numerics.accuracy": 0.1})
    for scene, errors in ((SCENE, False), (told, True)):
        tree = simulate_as_given(scene, groups=["history"])
        assert set(tree.children) == {"history", "ratings"}
        assert ("safety_error" in tree["ratings"]) == errors


def test_sensitivities_of_a_rated_scene():
    slopes = sw.sensitivities(SCENE, "root_stress_max[gear]", [TORQUE], workers=0)
    assert not str(slopes["message"].values[0])
    assert 0.5 < float(slopes["relative"][0, 0]) < 1.5


@pytest.mark.slow
def test_ratings_and_ends_know_the_coefficient_itself():
    """Miner's sum counts meshes, of which there are fewer to a depth the faster it wears."""
    values, changed = [1e-13, 2e-12], DEPTHS.replace({K: 2e-12})
    found = sw.sweep(DEPTHS, {K: values}, measure="ratings", workers=0)
    ratings = sw.simulate(changed)["ratings"]
    for name in ("damage_sum", "safety", "meshes_to_failure"):
        np.testing.assert_allclose(found[name][1], ratings[name], rtol=1e-9, err_msg=name)
    lives = sw.sweep(SCENE.replace({"effects.run_life": LIFE}), {K: values}, measure="life", workers=0)
    life = sw.simulate(SCENE.replace({"effects.run_life": LIFE, K: 2e-12}))["life"]
    for name in ("meshes_to_limit", "meshes_to_end", "hours_to_end"):
        assert float(lives[name][1]) == pytest.approx(float(life[name]), rel=1e-9)
    assert "ended_by" not in lives
    assert float(lives["meshes_to_end"][0] / lives["meshes_to_end"][1]) != pytest.approx(20.0, rel=0.01)


@pytest.mark.parametrize(
    "ends_at, measure, shared",
    [
        ("depth", "history", True), ("depth", None, True), ("depth", "ratings", False),
        ("first_failure", None, False),
        ("first_failure", "meshes_to_limit", True), ("first_failure", "hours_to_end", False),
    ],
)  # fmt: skip
def test_scenes_share_what_does_not_count_meshes(ends_at, measure, shared):
    base = DEPTHS.replace({"effects.run_life": {**LIFE, "ends_at": ends_at}})
    scene, stretch = shared_solution(base.replace({K: 2e-13}), base, measure_of(measure, "all"))
    assert (stretch == 0.5) == (scene == base) == shared


def test_text_of_an_earlier_store_is_left_alone():
    variation, measure = read_variation(SCENE, {TORQUE: [200.0]}, "grid"), measure_of("life", "all")
    store = MemoryStore()
    kept = Measured({"/life/meshes_to_end": np.asarray(7.0), "/life/ended_by": np.asarray("pitting")})
    store.put(Outcome("key", Status.DONE, measured=kept))
    found = assembled(SCENE, variation, replace(measure, last=True), [Member("key")], store)
    assert float(found["meshes_to_end"][0]) == 7.0 and "ended_by" not in found


def test_values_stand_under_the_names_of_their_scene():
    """A scene that rates fewer modes, or in another order, has its own numbers under each of them."""
    variation, store = read_variation(SCENE, {TORQUE: [100.0, 200.0]}, "grid"), MemoryStore()
    for key, modes in (("first", ["bending", "pitting"]), ("second", ["pitting", "scuffing"])):
        values = np.array([{"bending": 1.0, "pitting": 2.0, "scuffing": 3.0}[mode] for mode in modes])
        safety = np.broadcast_to(values[:, None, None], (2, 1, 2))
        coords = {"mode": np.array(modes), "body": np.array(["pinion", "gear"])}
        store.put(Outcome(key, Status.DONE, measured=Measured({"/ratings/safety": safety}, coords)))
    found = assembled(SCENE, variation, measure_of("ratings", "all"), [Member("first"), Member("second")], store)
    by_name = found["safety"].sel(mode=["bending", "pitting", "scuffing"])[:, :, 0, 0].values
    np.testing.assert_array_equal(by_name, [[1.0, 2.0, np.nan], [np.nan, 2.0, 3.0]])
