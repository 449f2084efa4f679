"""Patches on flanks worn at random: equations, monotony, symmetry, and the tree that comes out."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import semiwear as sw
from semiwear.closed_forms.love import love_coefficients
from semiwear.contact.gap import gap_of_flanks
from semiwear.plan import plan
from tests.scenes import MEDIUM, SHIPPED
from tests.strategies.examples import share_of_examples
from tests.strategies.finite import equations_hold

PATCHES = SHIPPED.replace(
    MEDIUM
    | {
        "wear.until.control_depths_um": None,
        "wear.control_point": None,
        "wear.until.meshes": 1e9,
        "numerics.wear_steps": 2,
        "numerics.fidelity": "patch",
        "numerics.cells_per_half_width": 4,
    }
)
SHAPE = (PATCHES.numerics.profile_points, PATCHES.numerics.face_slices)

few = share_of_examples(4, 4)
fewer = share_of_examples(8, 3)

torques = st.floats(50.0, 3000.0)
meshes = st.floats(7.5, 9.5).map(lambda exponent: 10.0**exponent)
mappings = st.sampled_from(["interpolated", "marched"])


@st.composite
def wear_maps(draw: st.DrawFn) -> np.ndarray:
    """Smooth hills and valleys of up to 40 um, (profile, face); some flanks bear scratches."""
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    p, f = (np.linspace(0.0, 1.0, n) for n in SHAPE)
    depth = np.zeros(SHAPE)
    for _ in range(draw(st.integers(0, 4))):
        waves, phases = random.integers(0, 5, 2), random.uniform(0.0, 2.0 * np.pi, 2)
        depth += np.outer(np.cos(np.pi * waves[0] * p + phases[0]), np.cos(np.pi * waves[1] * f + phases[1]))
    depth -= depth.min()
    if draw(st.booleans()):
        depth[random.random(SHAPE[0]) < 0.05] += 0.1
    return draw(st.floats(0.0, 40.0)) * depth / max(depth.max(), 1.0)


@pytest.mark.slow
@given(wear_maps(), torques)
@few
def test_equations_of_contact_hold(depth, torque):
    scene = PATCHES.replace({"operation.pinion_torque_Nm": torque})
    equations_hold(sw.loaded_contact(scene, wear_depth=depth))


@given(wear_maps(), torques)
@fewer
def test_cells_press_where_the_gap_is_closed(depth, torque):
    """The displacement anew, from the forces and Love's coefficients, without the solver."""
    teeth = plan(PATCHES.replace({"operation.pinion_torque_Nm": torque, "numerics.tooth_compliance": "rigid"}))
    teeth = teeth.loaded_teeth()
    state = teeth.load(np.ascontiguousarray(1e-3 * depth.T))
    problem, loads = teeth.problem, state.loads
    position, columns = 5, loads.cells.shape[-1]
    faces = np.arange(SHAPE[1])
    approach = float(loads.rotation[position] * teeth.lines.lever_arm.max())
    rolls = problem.rolls_of(position)
    everything = []
    for roll in rolls:
        flanks = gap_of_flanks(problem.lines, state.coarse.removed)
        gap, _ = problem.cells.gap(np.full(faces.size, roll), faces, approach, columns, flanks)
        force = loads.cells[roll]
        rows, places = np.nonzero(force)
        reached = love(problem, (faces.size, columns))
        displacement = np.zeros(force.shape)
        for row, place in zip(rows, places, strict=True):
            displacement += force[row, place] * reached[np.abs(faces - row)][:, np.abs(np.arange(columns) - place)]
        slack = gap + displacement - loads.rotation[position] * teeth.lines.lever_arm[roll][:, None]
        on = force > 0.0
        everything.append((np.abs(slack[on]).max(initial=0.0), slack[~on].min()))
        assert (force >= 0.0).all()
    assert max(pressed for pressed, _ in everything) < 2e-6 * approach
    assert min(free for _, free in everything) > -2e-6 * approach
    moment = (loads.force * teeth.lines.lever_arm)[rolls].sum()
    np.testing.assert_allclose(moment, 1e3 * torque, rtol=1e-9)


def love(problem, shape):
    """Displacement [mm] at cell offsets from a unit force on a cell."""
    cell = (problem.slice_length, problem.cells.width)
    return love_coefficients(shape, cell) / (problem.modulus * cell[0] * cell[1])


@given(wear_maps(), torques, st.floats(1.05, 2.0))
@fewer
def test_approach_grows_with_torque(depth, torque, factor):
    low, high = (
        sw.loaded_contact(PATCHES.replace({"operation.pinion_torque_Nm": value}), wear_depth=depth)["mesh_cycle"]
        for value in (torque, factor * torque)
    )
    assert (high.transmission_error_loaded < low.transmission_error_loaded).all()


@given(st.floats(0.0, 100.0))
@fewer
def test_even_wear_only_delays_the_contact(depth):
    """The same depth everywhere moves the gear, and nothing else."""
    one, two = sw.loaded_contact(PATCHES), sw.loaded_contact(PATCHES, wear_depth=np.full(SHAPE, depth))
    for name in ("load_share", "contact_pressure_max", "line_load", "root_stress"):
        greatest = float(np.abs(one["engagement"][name]).max())
        np.testing.assert_allclose(
            two["engagement"][name], one["engagement"][name], atol=1e-3 * greatest, rtol=0.0, err_msg=name
        )


@pytest.mark.slow
@given(meshes, mappings)
@few
def test_wear_never_shrinks(count, mapping):
    scene = PATCHES.replace({"wear.until.meshes": count, "numerics.wear_mapping": mapping, "numerics.wear_steps": 3})
    depth = sw.simulate(scene)["flank"].wear_depth.values
    assert np.isfinite(depth).all()
    assert (depth[0] == 0.0).all()
    assert (np.diff(depth, axis=0) >= 0.0).all()
    assert depth[-1].max() > 0.0


@pytest.mark.slow
@given(st.floats(0.1, 10.0), mappings)
@fewer
def test_meshes_and_wear_coefficient_count_as_their_product(factor, mapping):
    scene = PATCHES.replace({"numerics.wear_mapping": mapping})
    one = sw.simulate(scene)
    two = sw.simulate(
        scene.replace(
            {
                "wear.until.meshes": scene.wear.until.meshes / factor,
                "wear.coefficient_mm2_per_N": scene.wear.coefficient_mm2_per_N * factor,
            }
        )
    )
    depth = one["flank"].wear_depth.values
    # rounding alone differs, unless it decides about a cell at the rim: that is met to 1e-6
    np.testing.assert_allclose(two["flank"].wear_depth.values, depth, rtol=0.0, atol=1e-6 * depth.max())


@pytest.mark.slow
@given(wear_maps(), torques)
@fewer
def test_coast_mirrors_drive(depth, torque):
    scene = PATCHES.replace({"operation.pinion_torque_Nm": torque})
    one, two = (
        sw.loaded_contact(scene.replace({"operation.loaded_flank": flank}), wear_depth=depth)
        for flank in ("drive", "coast")
    )
    for group in ("engagement", "mesh_cycle", "diagnostics"):
        assert two[group].dataset.equals(one[group].dataset)
