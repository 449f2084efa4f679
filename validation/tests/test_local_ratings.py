"""Stresses of ISO 6336 that local safeties are compared with, and the comparison itself."""

from dataclasses import replace
from math import cos, radians

import pytest

from semiwear.scene import scene_from_dict
from validation.iso_rating import iso_stresses
from validation.local_ratings import TRENDS, compared, drawn_scenes, trend_scenes

STEEL = {"youngs_modulus_MPa": 206000.0, "poissons_ratio": 0.3}
# FZG C14 and H501 of the public program Gear-Calculation (C. Fernandes, FEUP), GearC/DIN3990.py at commit 0e4a135,
# 130 N m on the pinion: as it prints them. Its tip radii of the rack are 0.375 and 0.3 modules.
C14 = {
    "pinion_teeth": 16,
    "gear_teeth": 24,
    "normal_module_mm": 4.5,
    "helix_angle_deg": 0.0,
    "centre_distance_mm": 91.50007859607446,
    "pinion_profile_shift": 0.1817,
    "gear_profile_shift": 0.1715,
    "pinion_face_width_mm": 14.0,
    "pinion_tip_diameter_mm": 2.0 * 41.228329,
    "gear_tip_diameter_mm": 2.0 * 59.182429,
    "pinion_rack_tip_radius_mm": 0.375 * 4.5,
    "gear_rack_tip_radius_mm": 0.375 * 4.5,
}
H501 = {
    "pinion_teeth": 20,
    "gear_teeth": 30,
    "normal_module_mm": 3.5,
    "helix_angle_deg": 15.0,
    "centre_distance_mm": 91.50025755899904,
    "pinion_profile_shift": 0.1809,
    "gear_profile_shift": 0.0891,
    "pinion_face_width_mm": 23.0,
    "pinion_tip_diameter_mm": 2.0 * 40.336408,
    "gear_tip_diameter_mm": 2.0 * 58.132441,
    "pinion_rack_tip_radius_mm": 0.3 * 3.5,
    "gear_rack_tip_radius_mm": 0.3 * 3.5,
}


@pytest.mark.parametrize(
    ("pair", "contact", "z_epsilon", "root"),
    [
        (C14, 995.5857022874662 * 1.074878791565416, 0.9241831346430969, (177.84498178, 172.42172261)),
        (H501, 715.1964918452883 * 1.0210757138101156, 0.8712684261382845, (124.5390953, 124.81895089)),
    ],
    ids=["C14", "H501"],
)
def test_nominal_stresses_are_those_of_a_public_program(pair, contact, z_epsilon, root):
    table = {"type": "cylindrical", "pressure_angle_deg": 20.0} | pair
    operation = {"pinion_torque_Nm": 130.0}
    found = iso_stresses(
        scene_from_dict({"gear_pair": table, "operation": operation, "material": {"pinion": STEEL, "gear": STEEL}})
    )
    # it divides the torque by the working pitch radius where the standard has the reference radius
    reference = 0.5 * pair["normal_module_mm"] * pair["pinion_teeth"] / cos(radians(pair["helix_angle_deg"]))
    load = 3551.909 * reference / 130e3
    assert found.contact_ratio_factor == pytest.approx(z_epsilon, rel=1e-4)
    # and Z_beta of DIN 3990:1987, the root of cos beta where ISO 6336-2 has its inverse
    beta = cos(radians(pair["helix_angle_deg"]))
    assert found.contact[0] * load**0.5 * beta == pytest.approx(contact, rel=2e-3)
    assert [stress * load for stress in found.root_2006] == pytest.approx(root, rel=2e-3)


def test_the_drawn_pairs_are_twenty_and_of_both_kinds():
    scenes = drawn_scenes()
    helices = [scene.gear_pair.helix_angle_deg for scene in scenes]
    assert len(scenes) == 20 and helices.count(0.0) == 10
    assert sum(scene.effects.modification.pinion is None for scene in scenes) in range(4, 17)
    assert all(len(trend_scenes(name)) == len(values) for name, values in TRENDS.items())


def test_a_spur_pair_without_the_contact_ratio_factor_is_rated_alike():
    """In single pair contact the whole load is on one line: local and global pressure differ by its evenness only."""
    scene = drawn_scenes(3)[2]
    coarse = {"numerics.face_slices": 21, "numerics.roll_positions": 12, "numerics.profile_points": 61}
    one = compared(scene.replace(coarse | {"numerics.harmonics": 9}))
    whole, local = one.pitting
    assert local / whole / one.iso.contact_ratio_factor == pytest.approx(1.0, abs=0.06)
    doubled = replace(one, pressure=2.0 * one.pressure)
    assert doubled.pitting[1] == pytest.approx(0.5 * local)
