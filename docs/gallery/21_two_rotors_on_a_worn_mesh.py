"""
Two rotors on a worn mesh
=========================

What the shafts feel of wear. A spur pair is worn; two shafts in `ROSS <https://ross.readthedocs.io>`_ (extra
``rotors``) are coupled by its mesh stiffness, and its transmission error shakes them.
"""

import matplotlib.pyplot as plt
import numpy as np

import semiwear as sw

COARSE = {
    "numerics.face_slices": 11,
    "numerics.roll_positions": 12,
    "numerics.profile_points": 41,
    "numerics.harmonics": 5,
    "numerics.wear_steps": 2,
}
tree = sw.simulate(sw.load_scene("spur_fzg_c").replace(COARSE))
mesh = sw.mesh_stiffness(tree)

# %%
# Stiffness and transmission error over one mesh, unworn and worn.
states = {"unworn": 0, "worn": -1}
figure, axes = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
for ax, name, unit in zip(axes, ("mesh_stiffness_local", "transmission_error_loaded"), ("N/mm", "um"), strict=True):
    for state, step in states.items():
        ax.plot(mesh.mesh_position, mesh[name].isel(wear_step=step), label=state)
    ax.set(xlabel="mesh position [base pitches]", ylabel=f"{name.replace('_', ' ')} [{unit}]")
axes[0].legend()

# %%
# A shaft with a gear in the middle of two bearings, twice. The mesh takes the mean of the local stiffness; so much of
# it as the transmission error varies by is the force that shakes: :math:`F = k e` in the direction of the line of
# action, which ROSS has in its coupling matrix.
import warnings

try:
    with warnings.catch_warnings(action="ignore"):  # about data of gases, which it can do without
        import ross
except ImportError:
    ross = None
    print('ROSS is not installed, the rest is skipped: pip install "semiwear[rotors]"')

PRESSURE_ANGLE = np.radians(20.0)


def shaft(teeth, base_radius, mass, polar_inertia):
    """A shaft of steel, 160 mm long and 30 mm thick, with its gear."""
    steel = ross.Material("steel", rho=7810.0, E=211e9, G_s=81.2e9)
    elements = [ross.ShaftElement(L=0.04, idl=0.0, odl=0.03, material=steel) for _ in range(4)]
    gear = ross.GearElement(
        n=2, m=mass, Id=0.6 * polar_inertia, Ip=polar_inertia, n_teeth=teeth, base_diameter=2.0 * base_radius,
        pr_angle=PRESSURE_ANGLE,
    )  # fmt: skip
    bearings = [ross.BearingElement(n=n, kxx=2e8, cxx=2e3) for n in (0, 4)]
    return ross.Rotor(elements, [gear], bearings)


def two_shafts(stiffness):
    """Both, coupled by a mesh stiffness [N/mm]."""
    z1, z2 = mesh.attrs["pinion_teeth"], mesh.attrs["gear_teeth"]
    lever = 1e-3 * mesh.attrs["lever_arm_mm"]  # base radius of the pinion, m
    pinion, gear = shaft(z1, lever, 1.0, 6e-4), shaft(z2, z2 / z1 * lever, 2.2, 3.2e-3)
    return ross.MultiRotor(pinion, gear, coupled_nodes=(2, 2), gear_mesh_stiffness=1e3 * stiffness)


def dynamic_error(step, speeds_rpm, harmonics=3):
    """Amplitude of the dynamic transmission error [um] at speeds of the pinion, harmonics of the mesh added."""
    one = mesh.isel(wear_step=step)
    stiffness = float(one.mesh_stiffness_local.mean())
    model = two_shafts(stiffness)
    coupling = model.coupling_matrix()
    along = coupling[:, 0] / np.sqrt(coupling[0, 0])  # displacement along the line of action of each coordinate
    gears = (model.mesh.driving_gear, model.mesh.driven_gear)
    places = [place for gear in gears for place in gear.dof_global_index.values()]
    error = 2.0 * np.fft.rfft(one.transmission_error_loaded.values) / one.sizes["mesh_position"]  # um
    total = np.zeros(len(speeds_rpm))
    for n in range(1, harmonics + 1):
        omega = n * one.attrs["pinion_teeth"] * speeds_rpm * np.pi / 30.0
        force = np.zeros((model.ndof, len(omega)), complex)
        force[places] = 1e3 * stiffness * 1e-6 * error[n] * along[:, None]
        response = model.run_forced_response(force=force, speed_range=omega).forced_resp
        total += np.abs(1e6 * (along @ response[places]))
    return total


# %%
# Dynamic transmission error over the speed: every harmonic of the mesh frequency meets the frequency at which the
# wheels turn against the mesh. Wear hardly moves that frequency. It changes the excitation: less of it is left at the
# mesh frequency, more of it is at twice that.
if ross:
    speeds = np.linspace(200.0, 12000.0, 160)
    figure, ax = plt.subplots(layout="constrained")
    for state, step in states.items():
        ax.semilogy(speeds, dynamic_error(step, speeds), label=state)
        stiffness = float(mesh.mesh_stiffness_local.isel(wear_step=step).mean())
        frequencies = two_shafts(stiffness).run_modal(0.0, num_modes=24).wn / (2.0 * np.pi)
        print(f"{state}: k = {stiffness:.3g} N/mm, natural frequencies", np.unique(frequencies.round(0))[1:8], "Hz")
    ax.set(xlabel="speed of the pinion [rpm]", ylabel="dynamic transmission error, amplitude [um]")
    ax.legend()
