"""A pair has no size of its own: scaled with its load, it wears alike.

Lengths times s and torque times s^3 leave stresses and angles alone; the wear depth grows as the lengths do at the
same wear coefficient and meshes, since line loads grow with s and specific sliding stays. Only rounding is left.
"""

import pytest

import semiwear as sw
from semiwear.scene import scene_from_dict
from tests.scenes import TINY
from tests.strategies.point_flanks import exported, scene_of
from tests.strategies.scaling import dimensionless_difference, scaled, scaled_grid

FACE_GEAR = {
    "gear_pair": {
        "type": "face_gear",
        "pinion_teeth": 25,
        "shaper_teeth": 28,
        "gear_teeth": 160,
        "module_mm": 6.35,
        "pressure_angle_deg": 25,
        "gear_inner_radius_mm": 480,
        "gear_outer_radius_mm": 560,
        "pinion_face_width_mm": 80,
    },
    "operation": {"pinion_torque_Nm": 1600.0},
    "wear": {
        "coefficient_mm2_per_N": 1e-13,
        "worn_bodies": ["gear"],
        "until": {"control_depths_um": [10.0, 25.0]},
        "control_point": {"radius_mm": 508.0, "height_mm": -4.0},
    },
}
CYLINDRICAL = {
    "gear_pair": {
        "type": "cylindrical",
        "pinion_teeth": 20,
        "gear_teeth": 31,
        "normal_module_mm": 4.0,
        "pressure_angle_deg": 20.0,
        "pinion_face_width_mm": 30.0,
    },
    "operation": {"pinion_torque_Nm": 400.0},
    # steps are counted by their depth
    "wear": {"coefficient_mm2_per_N": 1e-13, "worn_bodies": ["pinion", "gear"], "until": {"meshes": 2e8}},
}


@pytest.fixture(scope="module")
def pairs(tmp_path_factory):
    """One scene of every kind of pair, with as many defaults as there are, and a folder for files."""
    folder = tmp_path_factory.mktemp("points")
    helical = CYLINDRICAL | {"gear_pair": CYLINDRICAL["gear_pair"] | {"helix_angle_deg": 20.0}}
    internal = CYLINDRICAL | {"gear_pair": CYLINDRICAL["gear_pair"] | {"gear_teeth": -67}}
    scenes = {
        "face gear": scene_from_dict(FACE_GEAR),
        "spur": scene_from_dict(CYLINDRICAL),
        "helical": scene_from_dict(helical),
        "internal": scene_from_dict(internal),
    }
    data = exported(scenes["spur"], folder, (41, 41), lambda _, grid: scaled_grid(grid, 1.0))
    points = data["gear_pair"]
    data["gear_pair"] = {name: value for name, value in points.items() if not name.endswith("_edge_radius_mm")}
    scenes["points"] = scene_of(data)
    return {
        name: scene.replace(TINY | {"numerics.cells_per_half_width": 3}) for name, scene in scenes.items()
    }, folder


def test_the_pairs_leave_their_defaults_to_the_package(pairs):
    for name, scene in pairs[0].items():
        radius = scene.gear_pair.pinion_tip_edge_radius_mm
        assert radius == "auto" or "pinion_tip_edge_radius_mm" in scene.gear_pair._derived, name


@pytest.mark.slow
@pytest.mark.parametrize("fidelity", ["line", "patch"])
@pytest.mark.parametrize("kind", ["face gear", "spur", "helical", "internal", "points"])
def test_a_scaled_pair_wears_alike(pairs, kind, fidelity):
    scenes, folder = pairs
    scene = scenes[kind].replace({"numerics.fidelity": fidelity})
    one = sw.simulate(scene)
    assert float(one["flank"]["wear_depth"].max()) > 5.0
    for size in (0.05, 10.0):  # a module of 0.2 mm is the smallest of them
        other = sw.simulate(scaled(scene, size, folder))
        apart = dimensionless_difference(one, other, size)
        assert max(apart.values()) < 1e-6, (size, {name: value for name, value in apart.items() if value >= 1e-6})
