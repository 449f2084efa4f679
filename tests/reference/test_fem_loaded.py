"""Loaded contact in finite elements, on meshes so coarse that a position takes seconds, beside the core."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import semiwear as sw
from fem_reference.contact import ContactMeshError
from fem_reference.loaded import loaded_contact
from fem_reference.passage import Passage
from fem_reference.root_load import RootStress, carried
from fem_reference.simulation import simulate
from fem_reference.tooth_mesh import LOADED
from semiwear.errors import SceneError
from semiwear.results import check_tree
from tests.strategies.scaling import scaled

COARSE = {"elements_per_half_width": 1.0, "element_length": 6.0, "teeth": 5, "pinion_teeth": 5}
POSITION = 1 / 3


@pytest.fixture(scope="module")
def solved(small: sw.Scene) -> xr.DataTree:
    return loaded_contact(small, [POSITION + 2.0], root_stress=False, strict=False, **COARSE)


@pytest.fixture(scope="module")
def core(small: sw.Scene) -> xr.DataTree:
    return sw.loaded_contact(small, [POSITION])


@pytest.mark.slow
def test_result_has_the_schemas_names(solved: xr.DataTree) -> None:
    check_tree(solved)
    assert solved.attrs["fidelity"] == "finite elements"
    assert float(solved["mesh_cycle"].mesh_position[0]) == pytest.approx(POSITION)
    assert set(solved["diagnostics"].data_vars) >= {
        "elements_across",
        "reaches_border",
        "edge_contact",
        "smallest_gap",
    }


@pytest.mark.slow
def test_forces_balance_the_torque(small: sw.Scene, solved: xr.DataTree) -> None:
    engagement = solved["engagement"].isel(wear_step=0)
    assert float(engagement.load_share.sum()) == pytest.approx(1.0, abs=1e-12)
    assert float(solved["diagnostics"].load_balance_residual[0]) < 1e-10
    assert float(solved["diagnostics"].smallest_gap.min()) > -1e-9
    # line loads carry the same force: over the line's length, a little more than the face width
    force = 1.6e6 / (0.5 * 6.35 * 25 * np.cos(np.radians(25.0)))
    width = 80.0 / small.numerics.face_slices
    assert float(engagement.line_load.sum()) * width == pytest.approx(force, rel=0.03)


@pytest.mark.slow
def test_agrees_with_the_core(solved: xr.DataTree, core: xr.DataTree) -> None:
    """Coarsely; validation/finite_elements.py is the real comparison."""
    ours, theirs = xr.align(core["engagement"].to_dataset(), solved["engagement"].to_dataset(), join="right")
    assert np.abs(ours.load_share - theirs.load_share).max() < 0.03
    error = [float(tree["mesh_cycle"].transmission_error_loaded[0, 0]) for tree in (core, solved)]
    assert error[0] < 0.0
    assert error[1] == pytest.approx(error[0], rel=0.08)
    peak = [
        float(part.contact_pressure_max.sel(roll_position=POSITION, method="nearest")[0]) for part in (ours, theirs)
    ]
    assert peak[1] == pytest.approx(peak[0], rel=0.2)


@pytest.mark.slow
def test_even_wear_turns_the_gear_and_nothing_else(small: sw.Scene, solved: xr.DataTree) -> None:
    depth = np.full((small.numerics.profile_points, small.numerics.face_slices), 12.0)
    worn = loaded_contact(small, [POSITION], depth, root_stress=False, strict=False, **COARSE)
    arcsec_per_mm = (25 / 160) / (0.5 * 6.35 * 25 * np.cos(np.radians(25.0))) * 180 * 3600 / np.pi
    for name in ("transmission_error_loaded", "transmission_error_unloaded"):
        shift = float(worn["mesh_cycle"][name][0, 0]) - float(solved["mesh_cycle"][name][0, 0])
        assert shift == pytest.approx(-0.012 * arcsec_per_mm, rel=1e-6)
    for name in ("load_share", "contact_pressure_max", "line_load"):
        assert worn["engagement"][name].values == pytest.approx(solved["engagement"][name].values, rel=1e-6, abs=1e-9)


@pytest.mark.slow
def test_a_mesh_too_coarse_is_refused(small: sw.Scene) -> None:
    with pytest.raises(ContactMeshError, match="elements_per_half_width"):
        loaded_contact(
            small, [POSITION], elements_per_half_width=0.25, element_length=12.0, teeth=5, pinion_teeth=5,
            root_stress=False,
        )  # fmt: skip


def test_impossible_requests_are_refused(small: sw.Scene) -> None:
    with pytest.raises(SceneError, match="roll_positions"):
        loaded_contact(small, [np.nan])
    with pytest.raises(SceneError, match="wear_depth"):
        loaded_contact(small, [0.0], np.full((141, 31), np.nan))
    with pytest.raises(SceneError, match="no contact is possible"):
        loaded_contact(small, [0.0], placement=sw.Placement(axial_pinion_mm=200.0))


@pytest.mark.slow
def test_forces_keep_their_sum_and_moment_on_the_root_meshes(shipped: sw.Scene) -> None:
    mesh = RootStress(shipped).meshes["gear"]
    grid = mesh.flanks[0, LOADED]
    face, profile = np.array([483.0, 517.3, 555.1]), np.array([-3.0, 0.7, 1.9])
    carry = carried(grid, face, profile, int(grid.nodes.max()) + 1)
    assert np.asarray(carry.sum(axis=1)).ravel() == pytest.approx(1.0, abs=1e-12)
    points = np.zeros((carry.shape[1], 3))
    at = grid.nodes >= 0
    points[grid.nodes[at]] = grid.points[at]
    from semiwear.geometry.face_gear import FaceGearTooth

    table = shipped.gear_pair
    tooth = FaceGearTooth(
        table.shaper_teeth, table.gear_teeth, table.module_mm, np.radians(25.0), table.gear_addendum_mm,
        table.shaper_addendum_mm, table.shaper_tip_radius_mm, table.gear_rim_thickness_mm,
    )  # fmt: skip
    assert carry @ points == pytest.approx(tooth.points(face, profile)[0], abs=0.05)


@pytest.mark.slow
def test_moved_nodes_are_wear_as_gap(small: sw.Scene, solved: xr.DataTree) -> None:
    """40 um off a band of the flank: nodes really moved or a gap over the fresh mesh, within 1 % of what it does."""
    wear = np.zeros((small.numerics.profile_points, small.numerics.face_slices))
    wear[60:100] = 40.0 * np.sin(np.linspace(0.0, np.pi, 40))[:, None]
    gap, moved = (
        loaded_contact(small, [POSITION], wear, root_stress=False, strict=False, worn_flank=how, **COARSE)
        for how in ("gap", "moved_nodes")
    )
    error = [float(tree["mesh_cycle"].transmission_error_loaded[0, 0]) for tree in (solved, gap, moved)]
    assert abs(error[1] - error[0]) > 0.3
    assert error[2] == pytest.approx(error[1], abs=0.01 * abs(error[1]))
    assert moved["engagement"].load_share.values == pytest.approx(gap["engagement"].load_share.values, abs=3e-3)
    peak = [float(tree["engagement"].contact_pressure_max.max()) for tree in (gap, moved)]
    assert peak[1] == pytest.approx(peak[0], rel=0.01)


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("elements_per_half_width", 0.0),
        ("elements_per_half_width", np.nan),
        ("element_length", -2.0),
        ("element_length", np.inf),
        ("teeth", 3),
        ("teeth", 5.5),
        ("pinion_teeth", 0),
    ],
)
def test_a_mesh_that_cannot_be_is_refused_by_its_option(small: sw.Scene, option: str, value: float) -> None:
    with pytest.raises(SceneError, match=rf"^.*\n.* {option}: found {value}"):
        loaded_contact(small, [POSITION], **{**COARSE, option: value})


@pytest.mark.parametrize(
    ("elements", "told"),
    [
        ({"fillet": 7}, "fillet: found 7; allowed: an even"),
        ({"flank": 0}, "flank: found 0"),
        ({"land": 2}, "fillet, "),
    ],
)
def test_meshes_of_the_root_that_cannot_be_are_refused(small: sw.Scene, elements: dict[str, int], told: str) -> None:
    with pytest.raises(SceneError, match=told):
        loaded_contact(small, [POSITION], **COARSE, root_elements=elements)


def test_an_unknown_way_of_wearing_is_refused(small: sw.Scene) -> None:
    with pytest.raises(SceneError, match="moved_nodes"):
        loaded_contact(small, [POSITION], worn_flank="ale")


@pytest.mark.parametrize("torque", [0.0, -100.0, np.nan])
def test_torque_must_drive(small: sw.Scene, torque: float) -> None:
    """Scenes cannot be loaded like that; one that was made by hand is refused all the same."""
    turned = replace(small, operation=replace(small.operation, pinion_torque_Nm=torque))
    with pytest.raises(SceneError, match="pinion_torque_Nm"):
        loaded_contact(turned, [POSITION], root_stress=False)


@pytest.mark.slow
def test_passage_of_the_line(small: sw.Scene) -> None:
    """Nothing slides on the pitch cone, and elsewhere as much as the core says."""
    from fem_reference.kinematics import PairKinematics
    from fem_reference.rigid_lines import RigidFlank

    passage = Passage.of(RigidFlank(PairKinematics(small)))
    known = np.isfinite(passage.roll)
    assert 0.7 < known.mean() <= 1.0
    middle = int(np.argmin(np.abs(passage.face - 508.0)))
    column = passage.specific_sliding[:, middle]
    pitch = int(np.argmin(np.where(known[:, middle], column, np.inf)))
    assert column[pitch] < 0.02
    # the pitch cone crosses this column 0.14 mm above the pitch plane
    assert abs(passage.profile[pitch, middle]) < 0.2
    core = sw.simulate(small.replace({"wear.until.meshes": 1e7, "wear.control_point": None}))
    theirs = np.abs(core["flank"].specific_sliding.sel(body="gear").values)
    active = known & (core["flank"].active.sel(body="gear").values > 0) & (theirs > 0.05)
    ratio = passage.specific_sliding[active] / theirs[active]
    assert np.median(ratio) == pytest.approx(1.0, abs=0.02)
    assert np.quantile(np.abs(ratio - 1.0), 0.9) < 0.1
    large = Passage.of(RigidFlank(PairKinematics(scaled(small, 10.0))))
    np.testing.assert_allclose(large.roll, passage.roll, rtol=0.0, atol=1e-6)


def test_simulate_says_what_it_needs(small: sw.Scene) -> None:
    with pytest.raises(SceneError, match=r"wear"):
        simulate(small.replace({"wear": None}))
    with pytest.raises(SceneError, match="give the number of meshes"):
        simulate(small)  # the shipped scene wears to control depths
    with pytest.raises(SceneError, match="cycles"):
        simulate(small, meshes=1e7, cycles=0)
    with pytest.raises(SceneError, match="positions"):
        simulate(small, meshes=1e7, positions=0)
    both = {"wear.worn_bodies": ("pinion", "gear"), "wear.until.meshes": 1e7, "wear.control_point": None}
    with pytest.raises(SceneError, match="worn_bodies"):
        simulate(small.replace(both))


def test_effects_that_are_not_in_here_are_refused(small: sw.Scene) -> None:
    with pytest.raises(SceneError, match=r"effects\.friction"):
        loaded_contact(small.replace({"effects.friction": {}}), [POSITION])
