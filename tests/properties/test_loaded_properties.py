"""Loaded contact of scenes near the shipped one: equations, monotony, symmetry, scaling."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import semiwear as sw
from tests.scenes import SHIPPED, SMALL
from tests.strategies import placements, scenes
from tests.strategies.examples import share_of_examples
from tests.strategies.finite import equations_hold
from tests.strategies.hard_cases import mirrored

UNWORN = SHIPPED.replace(SMALL | {"wear": None})

# each is a loaded contact
few = share_of_examples(5, 4)
fewer = share_of_examples(12, 2)


def same(one, two, group, name, factor=1.0, tolerance=1e-9):
    expected = factor * one[group][name].values
    np.testing.assert_allclose(  # what is missing is missing in both
        two[group][name].values, expected, rtol=0.0, atol=tolerance * np.nanmax(np.abs(expected)), err_msg=name
    )


@pytest.mark.slow
@given(scenes())
@few
def test_equations_of_contact_hold(scene):
    tree = sw.loaded_contact(scene)
    equations_hold(tree)
    assert (tree["mesh_cycle"].transmission_error_loaded < tree["mesh_cycle"].transmission_error_unloaded).all()


@pytest.mark.slow
@given(st.floats(30.0, 2500.0), st.floats(1.02, 1.5), st.one_of(st.just(sw.Placement()), placements()))
@few
def test_approach_and_pressure_grow_with_torque(torque, factor, placement):
    low, high = (
        sw.loaded_contact(UNWORN.replace({"operation.pinion_torque_Nm": value}), placement=placement)
        for value in (torque, factor * torque)
    )
    name = "transmission_error_loaded"
    assert (high["mesh_cycle"][name] < low["mesh_cycle"][name]).all()
    unloaded = [tree["mesh_cycle"].transmission_error_unloaded.values for tree in (low, high)]
    np.testing.assert_allclose(unloaded[1], unloaded[0], atol=0.01)
    assert (high["mesh_cycle"].pairs_in_contact >= low["mesh_cycle"].pairs_in_contact).all()
    total = [tree["engagement"].line_load.sum(("face", "wear_step")).values for tree in (low, high)]
    assert (total[1] >= total[0] * (1.0 - 1e-6)).all()


@pytest.mark.slow
@given(scenes())
@few
def test_no_wear_is_zero_wear(scene):
    shape = (scene.numerics.profile_points, scene.numerics.face_slices)
    one = sw.loaded_contact(scene)
    for depth in (np.zeros(shape), np.zeros((2, *shape))):
        two = sw.loaded_contact(scene, wear_depth=depth)
        for group in ("engagement", "mesh_cycle", "diagnostics"):
            assert two[group].dataset.equals(one[group].dataset)


@pytest.mark.slow
@given(st.floats(0.0, 100.0))
@few
def test_even_wear_only_delays_the_contact(depth):
    """The same depth everywhere moves the gear, and nothing else."""
    even = np.full((UNWORN.numerics.profile_points, UNWORN.numerics.face_slices), depth)
    one, two = sw.loaded_contact(UNWORN), sw.loaded_contact(UNWORN, wear_depth=even)
    for name in ("load_share", "contact_pressure_max", "line_load", "root_stress"):
        same(one, two, "engagement", name, tolerance=1e-3)
    base_radius = UNWORN.gear_pair.pinion_pitch_radius_mm * np.cos(np.radians(UNWORN.gear_pair.pressure_angle_deg))
    lag = 1e-3 * depth / base_radius * 25.0 / 160.0 * np.degrees(1.0) * 3600.0
    for name in ("transmission_error_loaded", "transmission_error_unloaded"):
        moved = one["mesh_cycle"][name].values - two["mesh_cycle"][name].values
        np.testing.assert_allclose(moved, lag, atol=1e-3)


@given(placements())
@few
def test_drive_and_coast_flank_are_mirror_images(placement):
    one = sw.loaded_contact(UNWORN, placement=placement)
    two = sw.loaded_contact(UNWORN.replace({"operation.loaded_flank": "coast"}), placement=mirrored(placement))
    for group in ("engagement", "mesh_cycle"):
        assert two[group].dataset.equals(one[group].dataset)


@pytest.mark.slow
@given(st.floats(0.3, 3.0))
@fewer
def test_stiffness_and_torque_together_change_pressures_alone(factor):
    one = sw.loaded_contact(UNWORN)
    two = sw.loaded_contact(
        UNWORN.replace(
            {
                "operation.pinion_torque_Nm": factor * UNWORN.operation.pinion_torque_Nm,
                "material.pinion.youngs_modulus_MPa": factor * UNWORN.material.pinion.youngs_modulus_MPa,
                "material.gear.youngs_modulus_MPa": factor * UNWORN.material.gear.youngs_modulus_MPa,
            }
        )
    )
    for name in ("load_share", "sliding_distance"):
        same(one, two, "engagement", name, tolerance=1e-6)
    for name in ("line_load", "contact_pressure_max", "root_stress"):
        same(one, two, "engagement", name, factor, tolerance=1e-6)
    same(one, two, "mesh_cycle", "transmission_error_loaded", tolerance=1e-6)


@pytest.mark.slow
@given(scenes().filter(lambda scene: scene.wear is not None and scene.wear.until.meshes is not None))
@few
def test_wear_steps_of_any_scene(scene):
    tree = sw.simulate(scene.replace({"wear.until.meshes": 1e-3 / scene.wear.coefficient_mm2_per_N}))
    depth = tree["flank"].wear_depth.values
    assert np.isfinite(depth).all()
    assert (np.diff(depth, axis=0) >= 0.0).all()
    assert depth[-1].max() > 0.0
    equations_hold(tree)
