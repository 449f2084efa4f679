"""Wear steps that are deeper than usual ones are told, with what to give."""

import pytest
import xarray as xr

import semiwear as sw
from semiwear.results.deep_steps import deep_steps
from tests.scenes import SHIPPED

COARSE = {"numerics.face_slices": 11, "numerics.roll_positions": 8, "numerics.profile_points": 41}


def worn(scene: sw.Scene, pinion: list[float], gear: list[float], usual: float | None = 8.0) -> xr.DataTree:
    """A result of a scene whose flanks wear to these depths [um]."""
    depths = xr.DataArray([pinion, gear], dims=("body", "wear_step"), coords={"body": ["pinion", "gear"]})
    diagnostics = xr.Dataset() if usual is None else xr.Dataset({"usual_step_depth": usual})
    tree = xr.DataTree.from_dict({"/history": xr.Dataset({"wear_depth_max": depths}), "/diagnostics": diagnostics})
    tree.attrs["scene_toml"] = scene.to_toml()
    return tree


def test_deep_steps_are_counted_and_the_deepest_is_told() -> None:
    scene = SHIPPED.replace({"numerics.wear_scheme": "explicit"})
    (told,) = deep_steps(worn(scene, [0.0, 30.0, 54.0, 85.0], [0.0, 9.0, 12.0, 20.0]))
    assert told.startswith("2 of 3 wear steps take up to 31 um off the pinion, where 8 um a step are usual")
    assert told.endswith("Give more wear.until.control_depths_um.")


@pytest.mark.parametrize(("scheme", "deepest"), [("implicit", 24.0), ("two-stage", 48.0), ("explicit", 24.0)])
def test_a_step_in_two_stages_may_be_twice_as_deep(scheme: str, deepest: float) -> None:
    scene = SHIPPED.replace({"numerics.wear_scheme": scheme, "wear.until.meshes": 1e9})
    assert deep_steps(worn(scene, [0.0, 0.0], [0.0, deepest])) == []
    assert len(deep_steps(worn(scene, [0.0, 0.0], [0.0, deepest + 0.1]))) == 1


@pytest.mark.parametrize("scheme", ["implicit", "two-stage"])
def test_steps_to_control_depths_are_taken_in_parts_and_not_told(scheme: str) -> None:
    scene = SHIPPED.replace({"numerics.wear_scheme": scheme})
    assert deep_steps(worn(scene, [0.0, 300.0], [0.0, 60.0])) == []


def test_results_without_earlier_steps_or_by_an_accuracy_tell_nothing() -> None:
    assert deep_steps(worn(SHIPPED, [100.0], [100.0])) == []
    assert deep_steps(worn(SHIPPED, [0.0, 100.0], [0.0, 0.0], usual=None)) == []
    assert deep_steps(xr.DataTree()) == []


def test_a_run_in_one_step_is_told_and_one_in_its_own_steps_is_not() -> None:
    scene = sw.load_scene("spur_fzg_c").replace({"wear.until.meshes": 4e8} | COARSE)
    (told,) = deep_steps(sw.simulate(scene.replace({"numerics.wear_steps": 1})))
    assert "1 of 1 wear steps take" in told and told.endswith("Give more numerics.wear_steps.")
    assert deep_steps(sw.simulate(scene)) == []
