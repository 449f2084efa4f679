"""Safeties of one wear state: those of a run where it stands there, and what a state alone can tell of cycles."""

from importlib import import_module

import numpy as np
import pytest

import semiwear as sw
from semiwear.errors import SceneError
from semiwear.report import write_report
from tests.strategies.oil_and_case import OIL_AND_CASE
from tests.strategies.ratings import RATED_SPUR

SMALL = RATED_SPUR.replace(OIL_AND_CASE | {"effects.flash_temperature": {}})
SPECTRUM = {"effects.load_spectrum": {"torques_Nm": [150.0, 250.0], "shares": [0.7, 0.3]}}
WITHOUT_MEMORY = ["micropitting", "scuffing", "flank_fracture"]


def at_step(scene, run, step):
    """Ratings of the flanks that a run has at a wear step."""
    wear = run["flank"].wear_depth.isel(wear_step=step)
    return sw.loaded_contact(scene, wear_depth=wear, meshes=float(run["ratings"].meshes[step]))[
        "ratings"
    ].to_dataset()


@pytest.fixture(scope="module")
def run():
    return sw.simulate(SMALL)


@pytest.mark.parametrize("changes", [{}, {"wear.worn_bodies": ["gear"]}, SPECTRUM])
def test_safeties_are_those_of_the_run(changes, run):
    """Unworn to the last digit; worn as the loads of a wear step are solved, where nothing is added up."""
    scene = SMALL.replace(changes)
    there = sw.simulate(scene) if changes else run
    for step in (0, -1):
        found, expected = at_step(scene, there, step), there["ratings"].to_dataset().isel(wear_step=[step])
        modes = WITHOUT_MEMORY if step else found.mode.values.tolist()
        for name in ("safety", "safety_height", "safety_face", "required_safety"):
            own, theirs = (data[name].sel(mode=modes).values for data in (found, expected))
            if step:  # both ends of the face are alike
                np.testing.assert_allclose(np.abs(own), np.abs(theirs), rtol=1e-4, atol=1e-9)
            else:
                np.testing.assert_array_equal(own, theirs)
        assert found.attrs == expected.attrs


def test_damage_is_that_of_a_run_in_which_nothing_changes():
    """Stress that has been there all along: without wear the last step of a run is this contact after its meshes."""
    scene = SMALL.replace({"wear.coefficient_mm2_per_N": 1e-16, "wear.until.meshes": 1e5})
    there = sw.simulate(scene)
    found, expected = at_step(scene, there, -1), there["ratings"].to_dataset().isel(wear_step=[-1])
    # the loads of the run's unworn state are solved by another way: 0.03 % in pressure, 13 times that in damage
    for name, near in {"safety": 5e-4, "damage_sum": 1e-2}.items():
        np.testing.assert_allclose(found[name], expected[name], rtol=near, err_msg=name)
    assert (found.wear_step_of_failure == -1).all() and np.isnan(found.meshes_to_failure).all()


def test_the_worn_stress_all_along_is_worse_than_the_run(run):
    """Pressure has grown with wear, so that the damage of its end is more than that of the way there."""
    found = at_step(SMALL, run, -1).sel(mode="pitting")
    there = run["ratings"].safety.sel(mode="pitting").values
    assert (found.safety.values < there[-1]).all() and (found.safety.values > 0.9 * there[-1]).all()
    assert found.wear_step_of_failure.values.tolist() == [0, 0]  # before the one wear step that is told
    assert (found.meshes_to_failure < run["ratings"].meshes_to_failure.sel(mode="pitting")).all()


def test_fresh_flanks_are_those_of_no_wear(run):
    rated = sw.loaded_contact(SMALL)["ratings"].safety.values
    np.testing.assert_allclose(rated, run["ratings"].safety.values[:, :1], rtol=1e-5)


def test_a_state_with_ratings_can_be_reported(tmp_path, unseen):
    text = write_report(sw.loaded_contact(SMALL, meshes=1e7), tmp_path / "state.html").read_text(encoding="utf-8")
    assert "Safeties of the failure modes" in text


def test_single_positions_and_scenes_without_modes_are_not_rated():
    """The worst of some roll positions is not the worst of a mesh cycle."""
    assert "ratings" not in sw.loaded_contact(SMALL, [0.0, 0.3]).children
    plain = SMALL.replace({f"effects.{mode}": None for mode in ("pitting", "bending", *WITHOUT_MEMORY)})
    assert "ratings" not in sw.loaded_contact(plain).children


@pytest.mark.parametrize("meshes", [-1.0, float("nan"), float("inf")])
def test_meshes_are_a_number(meshes):
    with pytest.raises(SceneError, match=r"meshes: .*finite number >= 0"):
        sw.loaded_contact(SMALL, meshes=meshes)


def test_a_pinion_that_does_not_wear_is_not_worn(run):
    worn = run["flank"].wear_depth.isel(wear_step=-1)
    with pytest.raises(SceneError, match=r"worn pinion.*wear\.worn_bodies"):
        sw.loaded_contact(SMALL.replace({"wear.worn_bodies": ["gear"]}), wear_depth=worn)


def test_a_wear_depth_is_taken_by_its_labels(run):
    worn = run["flank"].wear_depth.isel(wear_step=-1)
    worn = worn * (1.0 + 0.02 * (worn.face - worn.face.mean()))

    def error(wear):
        return float(sw.loaded_contact(SMALL, wear_depth=wear)["mesh_cycle"].transmission_error_loaded.mean())

    as_it_is = error(worn)
    assert error(worn.transpose("face", "body", "profile")) == error(worn.isel(body=[1, 0])) == as_it_is
    pinion = np.stack([worn.sel(body="pinion").values, 0.0 * worn.sel(body="gear").values])
    assert error(worn.sel(body="pinion")) == error(worn.isel(body=[0])) == error(pinion) != as_it_is
    assert error(worn.sel(body="gear")) == error(worn.sel(body="gear").values) not in (as_it_is, error(pinion))


def test_bodies_of_a_wear_depth_are_those_of_the_pair(run):
    worn = run["flank"].wear_depth.isel(wear_step=-1)
    with pytest.raises(SceneError, match=r"wear_depth.body: found 'pinion, wheel'; allowed: each of pinion, gear"):
        sw.loaded_contact(SMALL, wear_depth=worn.assign_coords(body=["pinion", "wheel"]))


@pytest.mark.parametrize("step", [slice(None), [-1]])
def test_a_wear_depth_is_of_one_wear_step(run, step):
    with pytest.raises(SceneError, match=r"isel\(wear_step=-1\)"):
        sw.loaded_contact(SMALL, wear_depth=run["flank"].wear_depth.isel(wear_step=step))


@pytest.mark.parametrize("shape", [(61,), (3, 61, 11), (61, 10), (0, 61, 11)])
def test_a_wear_depth_has_the_shape_of_the_flanks(shape):
    with pytest.raises(SceneError, match=r"\(profile, face\) = \(61, 11\)"):
        sw.loaded_contact(SMALL, wear_depth=np.zeros(shape))


def test_faults_of_all_arguments_are_told_together_before_teeth_are_computed(monkeypatch):
    monkeypatch.setattr(import_module("semiwear.plan").Plan, "loaded_teeth", None)
    wear = np.full((2, 61, 11), -1.0)
    with pytest.raises(SceneError) as caught:
        sw.loaded_contact(SMALL.replace({"wear.worn_bodies": ["gear"]}), [np.nan], wear, meshes=-1.0)
    told = [(one.field, str(one.value)) for one in caught.value.problems]
    assert told == [
        ("meshes", "-1"),
        ("wear_depth", "negative or not finite"),
        ("wear_depth", "a worn pinion"),
        ("roll_positions", "[nan]"),
    ]


def test_a_wear_depth_of_one_slice_is_refused(run):
    worn = run["flank"].wear_depth.isel(wear_step=-1, face=3)
    with pytest.raises(SceneError, match=r"wear_depth\.face.*\n.*wear_depth: .*\(profile, face\)"):
        sw.loaded_contact(SMALL, wear_depth=worn)
