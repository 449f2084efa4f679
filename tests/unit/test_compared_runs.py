"""Runs that are to be compared with one another: smooth, and with prisms of one Young's modulus."""

from __future__ import annotations

import numpy as np
import pytest

import semiwear as sw
from semiwear.plan import Compared
from semiwear.simulate import simulate

COARSE = {
    "numerics.face_slices": 7,
    "numerics.roll_positions": 8,
    "numerics.profile_points": 41,
    "numerics.harmonics": 3,
    "numerics.wear_steps": 1,
    "numerics.threads": 1,
    "wear.until.meshes": 1e7,
}
YOUNG = "material.gear.youngs_modulus_MPa"


@pytest.fixture(scope="module")
def scene() -> sw.Scene:
    return sw.load_scene("spur_fzg_c").replace(COARSE)


def last(scene: sw.Scene, compared: Compared | None) -> dict[str, np.ndarray]:
    history = simulate(scene, compared=compared)["history"].dataset.isel(wear_step=-1)
    return {str(name): values.values for name, values in history.data_vars.items()}


def test_prisms_of_another_modulus_are_scaled(scene: sw.Scene) -> None:
    stiffer = scene.replace({YOUNG: 1.1 * scene.material.gear.youngs_modulus_MPa})
    scaled, own = last(stiffer, Compared.with_runs_of(scene)), last(stiffer, Compared.with_runs_of(stiffer))
    for name, values in own.items():
        np.testing.assert_allclose(scaled[name], values, rtol=1e-6, err_msg=name)
    other = last(scene, Compared.with_runs_of(scene))
    assert not np.allclose(other["transmission_error_mean"], own["transmission_error_mean"], rtol=1e-3)


def test_a_smooth_run_is_that_of_the_scene(scene: sw.Scene) -> None:
    smooth, plain = last(scene, Compared.with_runs_of(scene)), last(scene, None)
    assert smooth.keys() == plain.keys()
    for name in ("wear_depth_max", "contact_pressure_pitch", "root_stress_max", "transmission_error_amplitude"):
        np.testing.assert_allclose(smooth[name], plain[name], rtol=0.01, err_msg=name)
