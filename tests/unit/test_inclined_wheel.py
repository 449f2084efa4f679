"""Strain of the wheel under its teeth: a disc under even tension, an axial force, and a root as a notch in it."""

from math import pi

import numpy as np
import pytest
from numpy.testing import assert_allclose

import semiwear as sw
from semiwear.compliance import inclined_wheel, tooth_ends
from semiwear.compliance.annulus import Annulus
from semiwear.compliance.inclined_wheel import OFFSETS, POLYNOMIALS, RingInfluence, ring_influence
from semiwear.compliance.root import ROOT_FROM
from semiwear.compliance.strained_root import strained_root
from semiwear.geometry.cylindrical import CylindricalTooth
from semiwear.geometry.inclined_foot import FootRing, InclinedFoot
from semiwear.plan import teeth
from tests.strategies.tooth_sections import trapezoid

E, NU = 206000.0, 0.3
RADIAL, TANGENTIAL, AXIAL = 0, 1, 2
SPACED = {"pitch": 30.0, "rim": 30.0}


def influence(ring: FootRing, ground: float = 6.0) -> RingInfluence:
    return ring_influence(ring, E, NU, 6, ground)


def by(stress: np.ndarray, order: int, force: int) -> np.ndarray:
    """Stress of the loaded tooth's foot [polynomial] by a force that is spread as one."""
    return stress[OFFSETS == 0][0].reshape(POLYNOMIALS, POLYNOMIALS, 4)[:, order, force]


def test_a_disc_drawn_outwards_by_all_its_teeth_is_strained_as_lame_says(monkeypatch):
    """A thin disc held at its bore, nine teeth that meet: as Lame's disc under an even tension of its rim."""
    monkeypatch.setattr(inclined_wheel, "_LEAST_HARMONICS", 8)  # waves of whole feet, which even out, and no shorter
    bore, rim, width = 15.0, 40.0, 0.5
    ring = FootRing(bore, rim, width, 9, 2.0 * pi * rim / 9.0, 0.0)
    found = influence(ring, ground=0.002).stress.reshape(OFFSETS.size, POLYNOMIALS, POLYNOMIALS, 4)
    tension = 9.0 / (2.0 * pi * rim * width)
    growth = tension * (1.0 - NU**2) / E / (1.0 + NU + (1.0 - NU) * (bore / rim) ** 2)
    hoop, axial = growth * (1.0 - (bore / rim) ** 2), -2.0 * NU * growth / (1.0 - NU)
    assert_allclose(found[:, 0, 0, RADIAL].sum(), E / (1.0 - NU**2) * (hoop + NU * axial), rtol=0.01)


def test_an_axial_force_bends_a_wheel_like_a_disc():
    """The rim follows the force most where it acts: tension on the side that it moves to, none in the middle."""
    ring = FootRing(11.0, 40.0, 15.0, 20, 8.0, 0.0)
    bent = by(influence(ring).stress, 0, AXIAL)
    even = np.arange(POLYNOMIALS) % 2 == 0
    assert np.abs(bent[even]).max() < 1e-6 * bent[1]
    # over most of the face it rises evenly
    assert bent[1] > 2.0 * np.abs(bent[3:]).max()


def test_what_the_ground_does_is_left_to_the_stretch_of_tooth_and_ground():
    ring = FootRing(30.0, 36.0, 15.0, 20, 8.0, 0.4)
    found = influence(ring, ground=6.0)
    assert np.abs(found.stress[OFFSETS == 0]).max() < 1e-12
    assert np.abs(found.stress[OFFSETS == 1]).max() > 0.0
    beside = np.abs(found.compliance[OFFSETS == 1]).max()
    assert np.abs(found.compliance[OFFSETS == 0]).max() < 1e-12 * beside
    for one in (found, influence(ring, ground=3.0)):
        assert_allclose(one.compliance[OFFSETS == 0][0], one.compliance[OFFSETS == 0][0].T, atol=1e-15)


def test_elements_above_a_cylinder_do_not_depend_on_what_is_below():
    deep, shallow = Annulus(15.0, 40.0, 12.0, E, NU, 6, 34.0), Annulus(34.0, 40.0, 12.0, E, NU, 6, 34.0)
    walls = np.sort(deep._wall())[::-1], np.sort(shallow._wall())[::-1]
    assert_allclose(walls[0][: walls[1].size], walls[1], rtol=1e-14)
    assert walls[0][-1] == 15.0 and np.all(np.diff(walls[0]) < 0.0)


def test_the_root_is_a_shallow_notch_in_a_strained_wheel():
    share, factor = strained_root(trapezoid(**SPACED), poissons_ratio=NU)
    assert share[0] > 0.0 and share[-1] < 1.0 and np.all(np.diff(share) > 0.0)
    # the stress passes the flank by, and crowds below the fillet
    assert abs(factor[0]) < 0.5
    root = factor[share > ROOT_FROM]
    assert np.all(np.diff(root[: root.size // 2]) > 0.0)
    assert 1.2 < root.max() < 3.0


def test_a_rounder_fillet_is_a_blunter_notch():
    sharp, round_ = (
        strained_root(trapezoid(radius=radius, **SPACED), poissons_ratio=NU)[1].max() for radius in (2.0, 4.0)
    )
    assert 1.0 < round_ < 0.95 * sharp


def test_the_factor_of_the_root_does_not_depend_on_size():
    _, small = strained_root(trapezoid(**SPACED), poissons_ratio=NU)
    _, large = strained_root(trapezoid(28.0, 5.0, radius=4.0, pitch=60.0, rim=60.0), poissons_ratio=NU)
    assert_allclose(large, small, rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("sense", [1, -1])
def test_the_section_through_a_point_is_normal_to_the_tooth(sense: int) -> None:
    tooth = CylindricalTooth(23, False, 8.0, np.radians(20.0), np.radians(28.0), 0.16, 113.0, 10.0, 3.0, 15.0)
    foot, radius = InclinedFoot(tooth, 25.6, sense), np.array(tooth.reference_radius)
    aside, slope = float(foot.section_aside(radius)), sense * np.tan(tooth.helix_angle)
    # from the flank to the middle of the tooth, which runs with z: tangential, axial
    way = np.array([tooth.half_thickness(tooth.reference_radius) + slope * aside, aside])
    assert abs(way @ [slope, 1.0]) < 1e-12 * np.linalg.norm(way)
    assert np.sign(aside) == -sense
    assert foot.prism_aside(radius) == 0.0
    # the tooth is thinner at its tip
    assert sense * foot.prism_aside(np.array(tooth.tip_radius)) > 0.0


@pytest.mark.slow
def test_the_depth_of_the_ground_hardly_matters(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stretch and wheel share the ground: while it counted twice, half as much again was 2.8 % of the deflection."""
    monkeypatch.setenv("SEMIWEAR_CACHE_DIR", "off")
    coarse = {"numerics.face_slices": 21, "numerics.harmonics": 17, "numerics.profile_points": 41}
    scene = sw.load_scene("spur_fzg_c").replace(
        coarse | {"gear_pair.helix_angle_deg": 28.0, "gear_pair.centre_distance_mm": None}
    )
    caches = [one for one in vars(teeth).values() if hasattr(one, "cache_clear")]
    found = []
    try:
        for depth in (0.67, 1.0):
            monkeypatch.setattr(tooth_ends, "_GROUND", depth)
            for cache in caches:
                cache.cache_clear()
            found.append(sw.loaded_contact(scene, [0.25]))
    finally:
        for cache in caches:
            cache.cache_clear()
    error = [float(tree["mesh_cycle"].transmission_error_loaded[0, 0]) for tree in found]
    assert error[0] == pytest.approx(error[1], rel=0.01)
