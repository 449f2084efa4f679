"""Volume of wear: what force and sliding drive is on the maps of the flanks, or told as the edges' share."""

import numpy as np
import pytest

import semiwear as sw
from semiwear.meshing.flank_area import flank_area
from semiwear.meshing.flank_pair import DRIVEN, DRIVING
from semiwear.plan import plan

SPUR = sw.load_scene("spur_fzg_c").replace({"numerics.face_slices": 31})
FACE_GEAR = sw.load_scene("face_gear_25x160").replace(
    {
        "wear.control_point": None,
        "wear.until.meshes": 2e9,
        "numerics.face_slices": 31,
        "numerics.profile_points": 81,
        "numerics.roll_positions": 12,
    }
)
BOTH, GEAR = ({"wear.worn_bodies": bodies} for bodies in (["pinion", "gear"], ["gear"]))
PATCH = {"numerics.fidelity": "patch"}
MARCHED = PATCH | {"numerics.wear_mapping": "marched", "numerics.roll_positions": 24}
STEPS = {"numerics.wear_steps": 2}
WITHIN = 0.003

CASES = {
    "spur, line": (SPUR, BOTH),
    "spur, patch": (SPUR, BOTH | PATCH),
    "spur, marched": (SPUR, GEAR | MARCHED),
    "spur, explicit": (SPUR, BOTH | {"numerics.wear_scheme": "explicit", "wear.until.meshes": 1e7}),
    "spur, two stages": (SPUR, BOTH | {"numerics.wear_scheme": "two-stage"}),
    "face gear, line": (FACE_GEAR, BOTH),
    "face gear, patch": (FACE_GEAR, GEAR | PATCH),
    "face gear, marched": (FACE_GEAR, GEAR | MARCHED),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_flanks_and_edges_wear_by_what_force_and_sliding_drive(case):
    scene, changes = CASES[case]
    scene = scene.replace(STEPS | changes)
    tree = sw.simulate(scene)
    volume, on_edges = (tree["history"][name].values for name in ("wear_volume", "wear_volume_on_edges"))
    assert np.abs(tree["diagnostics"].wear_volume_residual.values).max() < WITHIN
    assert (volume[0] == 0.0).all()
    assert (on_edges[0] == 0.0).all()
    worn = np.array([body in scene.wear.worn_bodies for body in ("pinion", "gear")])
    assert (np.diff(volume, axis=0)[:, worn] > 0.0).all()
    assert (volume[:, ~worn] == 0.0).all()


MESHES = 1e5  # so few that wear changes no load


@pytest.mark.slow
def test_volume_of_a_spur_pair_is_its_closed_form():
    """k N (integral of F |l| (1 + z1/z2) over the pinion's angle): l runs along the line of action, F = T/r_b.

    Tips press a little before and after the path of contact, where flanks slide as if it went on.
    """
    k = 1e-13
    tree = sw.simulate(
        SPUR.replace(
            BOTH
            | {"wear.until.meshes": MESHES, "numerics.wear_steps": 1, "numerics.wear_scheme": "explicit"}
            | {"numerics.roll_positions": 96}
        )
    )
    teeth = np.array([16, 24])
    base_radius = 0.5 * 4.5 * 16 * np.cos(np.radians(20.0))
    roll, share = tree["engagement"].roll_position.values, tree["engagement"].load_share.values[0]
    along = 2.0 * np.pi * base_radius / 16 * np.abs(roll)
    angle = 2.0 * np.pi / 16 * np.gradient(roll)
    work = float(np.sum(302e3 / base_radius * share * along * (1.0 + 16 / 24) * angle))
    found = (tree["history"].wear_volume + tree["history"].wear_volume_on_edges).values[-1]
    np.testing.assert_allclose(found, k * MESHES * 24 / teeth * work, rtol=WITHIN)


@pytest.mark.slow
def test_edges_that_press_take_their_share_and_freed_ones_next_to_none():
    """The shipped pair has no relief: its tips bear over a hundredth of the volume until they have some."""
    few = STEPS | {"wear.until.meshes": 2e7}
    relief = {"tip_relief_um": 40.0, "tip_relief_length_mm": 2.0}
    shares = []
    for changes in (few, few | {f"effects.modification.{body}": relief for body in ("pinion", "gear")}):
        history = sw.simulate(SPUR.replace(changes))["history"]
        on_edges = history.wear_volume_on_edges.values[-1]
        shares.append(on_edges / (on_edges + history.wear_volume.values[-1]))
    assert (shares[0] > 0.01).all()
    assert (shares[1] < 1e-3).all()


def test_edges_that_are_relieved_wear_by_nothing_at_all():
    """Stretches of a footprint that are laid near an edge lie on the nodes but for rounding, which is no wear."""
    relief = {"tip_relief_um": 60.0, "tip_relief_length_mm": 2.0}
    scene = FACE_GEAR.replace({f"effects.modification.{body}": relief for body in ("pinion", "gear")})
    history = sw.simulate(scene)["history"]
    assert history.wear_volume.values[-1, 1] > 5.0
    assert (history.wear_volume_on_edges.values == 0.0).all()


def test_area_of_involute_flanks_is_in_closed_form():
    """Transverse arc length of the involute times the face width of all slices."""
    teeth = plan(SPUR).loaded_teeth()
    for body, grid in ((DRIVEN, teeth.grid), (DRIVING, teeth.driving.grid)):
        width = np.ptp(grid.face) * grid.face.size / (grid.face.size - 1)
        expected = width * np.ptp(grid.profile[0])
        assert flank_area(teeth.pair, body, grid).sum() == pytest.approx(expected, rel=1e-6)
