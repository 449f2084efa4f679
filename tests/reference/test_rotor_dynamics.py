"""ROSS takes the mesh stiffness of a worn pair: the mode in which two wheels turn against the mesh."""

import numpy as np
import pytest

import semiwear as sw
from tests.scenes import TINY

pytestmark = pytest.mark.slow


def test_two_rotors_on_a_worn_mesh():
    ross = pytest.importorskip("ross", reason="ROSS (extra rotors) is not installed")
    tree = sw.simulate(sw.load_scene("spur_fzg_c").replace(TINY | {"numerics.wear_steps": 1}))
    found = sw.mesh_stiffness(tree).isel(wear_step=-1)
    stiffness = 1e3 * float(found.mesh_stiffness_local.mean())  # N/m
    lever = 1e-3 * found.attrs["lever_arm_mm"]  # the base radius, m
    teeth = found.attrs["pinion_teeth"], found.attrs["gear_teeth"]
    ratio = teeth[1] / teeth[0]
    steel = ross.Material("steel", rho=7810.0, E=211e9, G_s=81.2e9)
    inertia = 0.01, 0.03

    def rotor(number, radius, polar):
        shaft = [ross.ShaftElement(L=0.02, idl=0.0, odl=0.02, material=steel) for _ in range(2)]
        gear = ross.GearElement(n=1, m=3.0, Id=0.005, Ip=polar, n_teeth=number, base_diameter=2.0 * radius,
                                pr_angle=np.radians(20.0))  # fmt: skip
        # so stiff at the gear that the wheels only turn
        return ross.Rotor(shaft, [gear], [ross.BearingElement(n=1, kxx=1e13, cxx=0.0)])

    pinion, gear = rotor(teeth[0], lever, inertia[0]), rotor(teeth[1], ratio * lever, inertia[1])
    model = ross.MultiRotor(pinion, gear, coupled_nodes=(1, 1), gear_mesh_stiffness=stiffness)
    modal = model.run_modal(0.0, num_modes=24)
    # two wheels on a spring between their base circles
    expected = np.sqrt(stiffness * lever**2 * (1.0 / inertia[0] + ratio**2 / inertia[1]))
    nearest = modal.wn[np.argmin(np.abs(modal.wn - expected))]
    assert nearest == pytest.approx(expected, rel=0.01)
