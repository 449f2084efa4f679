"""Sweeps that are really solved: the same numbers as runs of single scenes, wherever they run."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import semiwear as sw
from semiwear.simulate import simulate as simulate_as_given
from tests.scenes import RIGID, SHIPPED, TINY

SCENE = SHIPPED.replace({**TINY, "wear.until.control_depths_um": [2, 4]})
TORQUE, OFFSET, K = "operation.pinion_torque_Nm", "effects.misalignment.offset_mm", "wear.coefficient_mm2_per_N"
ROOT = Path(sw.__file__).parents[1]


def without_time(found):
    return found.drop_vars("seconds")


def test_a_sweep_holds_the_numbers_of_single_runs():
    found = sw.sweep(SCENE, {TORQUE: [800, 1600], OFFSET: [0.0, 0.05]}, measure=["history", "wear_depth"], workers=0)
    for torque, offset in ((800, 0.05), (1600, 0.0)):
        tree = sw.simulate(SCENE.replace({TORQUE: torque, OFFSET: offset}))
        one = found.sel(pinion_torque_Nm=torque, offset_mm=offset)
        for name, values in tree["history"].to_dataset().variables.items():
            np.testing.assert_array_equal(one[name].values, values.values, err_msg=name)
        np.testing.assert_array_equal(one["wear_depth"].values, tree["flank"]["wear_depth"].values)


def test_ends_alone_are_those_of_whole_runs():
    """Only the last wear state is told of, unless failure modes are rated, whose lives need them all."""
    bending = {"root_roughness_Rz_um": 10.0}
    for body in ("pinion", "gear"):
        bending |= {f"{body}_limit_MPa": 400.0, f"{body}_life_curve": "case_hardened"}
    rated = SCENE.replace({"effects.bending": bending})
    for scene, measure in ((SCENE, ["history", "flank", "engagement"]), (rated, ["history", "ratings"])):
        found = sw.sweep(scene, {TORQUE: [900.0]}, measure=measure, wear_states="last", workers=0)
        tree = sw.simulate(scene.replace({TORQUE: 900.0}))
        assert not found["status"].values.any(), found["message"].values
        for name in map(str, found.data_vars):
            group = next((group for group in measure if name in tree[group].variables), None)
            if group is not None:
                whole = tree[group].to_dataset()[name]
                end = whole.isel(wear_step=-1) if "wear_step" in whole.dims else whole
                np.testing.assert_array_equal(found[name].values[0], end.values, err_msg=name)
    alone = simulate_as_given(SCENE, last=True)["history"]
    assert alone.sizes["wear_step"] == 1 and int(alone["wear_step"][0]) == 2


def test_a_life_alone_is_that_of_a_whole_run():
    scene = SCENE.replace({"effects.run_life": {"depth_limit_um": 5.0}, "operation.pinion_speed_rpm": 100.0})
    whole = sw.simulate(scene)["life"].to_dataset()
    alone = sw.sweep(scene, {TORQUE: [1600]}, measure="life", workers=0).isel(pinion_torque_Nm=0)
    for name, value in whole.data_vars.items():
        assert float(alone[name]) == float(value), name


@pytest.mark.parametrize("wears", [["gear"], ["pinion", "gear"]])
def test_meshes_are_inverse_to_the_coefficient_as_runs_of_each_find(wears):
    """As exactly as the searches for the meshes go on in the same steps: to rounding."""
    scene = SHIPPED.replace({**RIGID, **TINY, "wear.worn_bodies": wears, "wear.until.control_depths_um": [3, 6]})
    found = sw.sweep(scene, {K: [1e-13, 3e-12]}, workers=0)
    own = sw.simulate(scene.replace({K: 3e-12}))["history"].to_dataset()
    for name in ("meshes", "wear_depth_max", "load_share_max", "contact_pressure_pitch"):
        np.testing.assert_allclose(found[name][1].values, own[name].values, rtol=1e-9, err_msg=name)
    np.testing.assert_allclose(found["meshes"][0, 1:] / found["meshes"][1, 1:], 30.0, rtol=1e-14)


@pytest.mark.slow
def test_processes_find_the_same_to_the_last_bit(tmp_path):
    vary = {TORQUE: [800, 1200, 1600], OFFSET: [0.0, 0.05]}
    here = sw.sweep(SCENE, vary, workers=0)
    there = sw.sweep(SCENE, vary, workers=2, store=tmp_path / "kept")
    assert without_time(there).identical(without_time(here))


@pytest.mark.slow
def test_a_script_needs_no_guard_and_may_be_killed(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        f"""
import semiwear as sw
scene = sw.load_scene("face_gear_25x160").replace({ {**TINY, "wear.until.control_depths_um": [2, 4]}!r})
class Tell:
    def step(self, done, total, text):
        print(done, flush=True)
found = sw.sweep(scene, {{{TORQUE!r}: [800, 900, 1000, 1100, 1200, 1300]}}, store="kept", progress=Tell())
found.to_netcdf("found.nc")
"""
    )
    with subprocess.Popen([sys.executable, script], cwd=tmp_path, stdout=subprocess.PIPE, text=True) as first:
        for line in first.stdout:
            if line.strip() == "2":
                first.send_signal(signal.SIGKILL)
    done = subprocess.run([sys.executable, script], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert int(done.stdout.split()[0]) >= 2
    whole = sw.sweep(SCENE, {TORQUE: [800, 900, 1000, 1100, 1200, 1300]}, workers=0)
    import xarray as xr

    with xr.open_dataset(tmp_path / "found.nc") as found:
        for name in whole.data_vars:
            if name not in ("seconds", "message"):
                np.testing.assert_array_equal(found[name].values, whole[name].values)


@pytest.mark.slow
def test_a_cluster_survives_a_worker_that_is_killed(tmp_path):
    distributed = pytest.importorskip("distributed")
    vary = {TORQUE: [*np.linspace(800, 1600, 12)], "gear_pair.gear_inner_radius_mm": [480.0, 440.0]}

    class Killer:
        """Kills the first worker once three scenes are done."""

        def __init__(self, pid):
            self.pid, self.told = pid, []

        def step(self, done, total, text):
            self.told.append(done)
            if self.pid and done >= 15:  # twelve are refused at once
                os.kill(self.pid, signal.SIGKILL)
                self.pid = None

    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        killer = Killer(next(iter(client.run(os.getpid).values())))
        there = sw.sweep(SCENE, vary, client=client, store=tmp_path / "kept", progress=killer)
    assert killer.pid is None and killer.told == [12, *range(13, 25)]
    here = sw.sweep(SCENE, vary, workers=0)
    assert without_time(there).identical(without_time(here))
    assert (there["status"].sel(gear_inner_radius_mm=440.0) == 1).all()
