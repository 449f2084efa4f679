"""Loaded contact of cylindrical pairs against ISO 6336 and against what spur and helical teeth are known to do."""

from math import acos, cos, pi, radians, sin, sqrt, tan

import numpy as np
import pytest

import semiwear as sw
from semiwear.closed_forms.hertz import line_contact_pressure
from semiwear.meshing.cylindrical_pair import CylindricalMesh
from semiwear.meshing.tooth_contact import contact_points
from semiwear.plan import plan

MODULE, ALPHA, WIDTH = 4.5, radians(20.0), 14.0
SMALL = {"numerics.face_slices": 21, "numerics.harmonics": 17}


@pytest.fixture(scope="module")
def spur() -> sw.Scene:
    return sw.load_scene("spur_fzg_c").replace({**SMALL, "wear": None})


@pytest.fixture(scope="module")
def helical(spur) -> sw.Scene:
    """The same size, wide enough for an overlap ratio of 1."""
    return spur.replace(
        {
            "gear_pair.helix_angle_deg": 25.0,
            "gear_pair.centre_distance_mm": None,
            "gear_pair.pinion_face_width_mm": 33.6,
            "operation.pinion_torque_Nm": 302.0 * 33.6 / WIDTH,
        }
    )


@pytest.fixture(scope="module")
def loaded(spur):
    return sw.loaded_contact(spur)


def pair_of(scene: sw.Scene) -> CylindricalMesh:
    pair = plan(scene).flank_pair()
    assert isinstance(pair, CylindricalMesh)
    return pair


@pytest.mark.slow
def test_nominal_pressure_at_the_pitch_point(spur):
    """ISO 6336-2: Z_H Z_E sqrt(F_t/(d_1 b) (u + 1)/u), all the load on one pair (Z_eps = Z_beta = 1)."""
    pair, table = pair_of(spur), spur.gear_pair
    working = table.working_pressure_angle
    zone = sqrt(2.0 * cos(working) / (cos(ALPHA) ** 2 * sin(working)))
    material = spur.material.pinion
    elasticity = sqrt(material.youngs_modulus_MPa / (2.0 * pi * (1.0 - material.poissons_ratio**2)))
    tangential = 2e3 * spur.operation.pinion_torque_Nm / (MODULE * 16)
    nominal = zone * elasticity * sqrt(tangential / (MODULE * 16 * WIDTH) * (1.0 + 16 / 24))
    force = 1e3 * spur.operation.pinion_torque_Nm / pair.lever_arm(np.zeros((1, 3)))[0]
    modulus = plan(spur).modulus
    curvature = contact_points(pair, np.zeros(1)).curvature[0, 1]
    assert float(line_contact_pressure(force / WIDTH, curvature, modulus)) == pytest.approx(nominal, rel=1e-6)
    # and on the solved line, whose load is not even along the face: p^2 is linear in the load
    alone = sw.loaded_contact(spur.replace({"numerics.tooth_pairs": 1}), [0.0])["engagement"]
    row = int(np.argmin(np.abs(alone.roll_position.values)))
    load = alone.line_load.values[0, row]
    assert load.sum() * float(alone.face[1] - alone.face[0]) == pytest.approx(force, rel=1e-6)
    # the slices at the ends are edges, whose pressure is told by itself
    inner = float(line_contact_pressure(load[1:-1].max(), curvature, modulus))
    assert float(alone.contact_pressure_max[0, row]) == pytest.approx(inner, rel=1e-3)
    assert inner == pytest.approx(nominal, rel=0.05)


@pytest.mark.slow
def test_load_at_the_ends_grows_steadily_with_slices(spur):
    """Towards the edge of a stiff end, as fine as slices are; one that lay partly on a rounding took 12 % off it."""
    greatest = []
    for slices in (61, 71, 81, 91, 101, 111, 121):
        scene = spur.replace({"numerics.face_slices": slices})
        greatest.append(float(sw.loaded_contact(scene, [0.0])["engagement"].line_load.max()))
    growth = np.diff(greatest) / greatest[0]
    assert growth.min() > 0.03 and growth.max() < 0.09


@pytest.mark.slow
def test_half_width_of_reference_is_that_of_a_line(spur, shipped):
    """Flanks that conform along the face make no ellipse; those of a face gear do, within its face."""
    rigid = {"numerics.tooth_compliance": "rigid"}
    teeth = plan(spur.replace(rigid)).loaded_teeth(roll_positions=np.zeros(1))
    force = 1e3 * spur.operation.pinion_torque_Nm / pair_of(spur).lever_arm(np.zeros((1, 3)))[0]
    curvature = contact_points(pair_of(spur), np.zeros(1)).curvature[0, 1]
    expected = sqrt(4.0 * force / WIDTH / (pi * plan(spur).modulus * curvature))
    assert teeth.half_width == pytest.approx(expected, rel=1e-6)
    ellipse = plan(shipped.replace(rigid)).loaded_teeth(roll_positions=np.zeros(1))
    assert ellipse.half_width == pytest.approx(0.525, abs=0.002)


def test_half_width_of_reference_is_that_of_the_loaded_flank(helical):
    """A left-hand pair on its coast flanks is a right-hand one on its drive flanks, with offset faces, too."""
    right = helical.replace({"gear_pair.face_offset_mm": 1.5, "numerics.tooth_compliance": "rigid"})
    left = right.replace({"gear_pair.hand": "left", "operation.loaded_flank": "coast"})
    one, two = (plan(scene).loaded_teeth(roll_positions=np.zeros(1)) for scene in (right, left))
    assert two.half_width == one.half_width
    assert two.problem.usual_half_width == one.problem.usual_half_width


def test_pressure_along_the_path(spur, loaded):
    """Hertz, with the radii of curvature of ISO 21771 at every roll position and the line load found there."""
    pair = pair_of(spur)
    engagement = loaded["engagement"]
    working = spur.gear_pair.working_pressure_angle
    first, last = pair.path_limits
    travel = -pair.base_pitch * engagement.roll_position.values
    inside = (travel < first - 1.0) & (travel > last + 1.0)
    rho = [r * sin(working) + s * travel for r, s in zip(pair.working_radii, (-1.0, 1.0), strict=True)]
    curvature = 1.0 / rho[0] + 1.0 / rho[1]
    # away from the rounded ends of the face, where the gap bends as well
    load = engagement.line_load.values[0][:, 1:-1].max(axis=1)
    expected = line_contact_pressure(load, curvature, plan(spur).modulus)
    found = engagement.contact_pressure_max.values[0]
    assert inside.sum() > 25
    np.testing.assert_allclose(found[inside], expected[inside], rtol=1e-3)


def test_load_is_shared_in_the_usual_pattern(spur, loaded):
    """Uncorrected spur teeth: from about 1/3 to 2/3 while two pairs share, all the load in between."""
    pair, engagement = pair_of(spur), loaded["engagement"]
    first, last = pair.path_limits
    roll, share = engagement.roll_position.values, engagement.load_share.values[0]
    enters, leaves = -first / pair.base_pitch, -last / pair.base_pitch
    alone, shares = leaves - 1.0, enters + 1.0
    # stiff teeth would take over at these points; deflected ones do so a little before (0.06 of a pitch here)
    double = (roll > enters + 0.06) & (roll < alone - 0.06)
    assert np.all((share[double] > 1 / 3) & (share[double] < 2 / 3))
    assert np.all(np.diff(share[double]) > 0.0)
    single = (roll > alone + 0.1) & (roll < shares - 0.1)
    assert single.sum() >= 5
    np.testing.assert_allclose(share[single], 1.0, atol=1e-9)
    late = (roll > shares + 0.06) & (roll < leaves - 0.06)
    assert np.all((share[late] > 1 / 3) & (share[late] < 2 / 3))
    assert np.all(np.diff(share[late]) < 0.0)


def theoretical_stiffness(z1: float, z2: float, x1: float, x2: float) -> float:
    """Theoretical single stiffness c'_th = 1/q' [N/(mm um)] (ISO 6336-1:2019, method B, external teeth)."""
    flexibility = 0.04723 + 0.15551 / z1 + 0.25791 / z2 - 0.00635 * x1 - 0.11654 * x1 / z1 - 0.00193 * x2
    flexibility += -0.24188 * x2 / z2 + 0.00529 * x1**2 + 0.00182 * x2**2
    return 1.0 / flexibility


def with_teeth(scene: sw.Scene, z1: int, z2: int, x1: float, x2: float, rim: float = 3.0) -> sw.Scene:
    """Other teeth, on rims of three modules: below, c'_th counts the tooth's own foundation and no turning disc."""
    bore = MODULE * (0.5 * z1 - 1.25 + x1 - rim)
    pair = {"pinion_teeth": z1, "gear_teeth": z2, "pinion_profile_shift": x1, "gear_profile_shift": x2}
    pair |= {"centre_distance_mm": None, "pinion_bore_radius_mm": bore, "gear_rim_thickness_mm": rim * MODULE}
    return scene.replace({f"gear_pair.{name}": value for name, value in pair.items()})


def stiffness(scene: sw.Scene, roll: float | None = None) -> float:
    """Load per face width and approach [N/(mm um)], at a roll position or as a mean over the mesh."""
    loaded = sw.loaded_contact(scene, None if roll is None else [roll])
    pair = pair_of(scene)
    force = 1e3 * scene.operation.pinion_torque_Nm / pair.lever_arm(np.zeros((1, 3)))[0]
    approach = -1e3 * float(loaded["mesh_cycle"].transmission_error_loaded.mean()) / pair.arcsec_per_mm
    return float(force / scene.gear_pair.pinion_face_width_mm / approach)


TEETH = [(16, 24, 0.1817, 0.1715), (20, 20, 0.0, 0.0), (25, 75, 0.2, 0.0), (40, 120, 0.0, 0.0)]


@pytest.mark.slow
@pytest.mark.parametrize("teeth", TEETH, ids=str)
def test_single_stiffness_against_iso_6336(spur, teeth):
    """One pair at the pitch point; method B is a fit to Weber and Banaschek's theory, before C_M = 0.8 of tests."""
    single = with_teeth(spur, *teeth).replace({"numerics.tooth_pairs": 1})
    assert stiffness(single, 0.0) == pytest.approx(theoretical_stiffness(*teeth), rel=0.15)


@pytest.mark.slow
def test_mesh_stiffness_against_iso_6336(spur):
    """c_gamma = c' (0.75 eps_alpha + 0.25), and its growth with the number of teeth."""
    found, expected = [], []
    for teeth in ((20, 20, 0.0, 0.0), (40, 120, 0.0, 0.0)):
        scene = with_teeth(spur, *teeth).replace({"numerics.face_slices": 11, "numerics.roll_positions": 16})
        found.append(stiffness(scene))
        expected.append(theoretical_stiffness(*teeth) * (0.75 * pair_of(scene).transverse_contact_ratio + 0.25))
    np.testing.assert_allclose(found, expected, rtol=0.15)
    assert found[1] > 1.2 * found[0]
    assert expected[1] > 1.2 * expected[0]


@pytest.mark.slow
def test_a_thinner_rim_is_stiffer_to_its_bore(spur):
    single = spur.replace({"numerics.tooth_pairs": 1})
    teeth = (25, 75, 0.0, 0.0)
    by_rim = [stiffness(with_teeth(single, *teeth, rim=rim), 0.0) for rim in (2.0, 4.0)]
    assert by_rim[0] > by_rim[1]


# ---------------------------------------------------------------- helical teeth


@pytest.mark.slow
def test_helical_lines_take_over_smoothly(spur, helical):
    pair = pair_of(helical)
    assert 0.95 < pair.overlap_ratio < 1.05
    straight, slanted = (sw.loaded_contact(scene) for scene in (spur, helical))
    amplitude = [float(np.ptp(tree["mesh_cycle"].transmission_error_loaded.values)) for tree in (straight, slanted)]
    assert amplitude[1] < 0.25 * amplitude[0]
    step = [float(np.abs(np.diff(tree["engagement"].load_share.values[0])).max()) for tree in (straight, slanted)]
    assert step[1] < 0.5 * step[0]
    # the loaded length of all lines hardly varies at a whole overlap ratio; that of spur teeth doubles
    lengths = [_loaded_length(tree) for tree in (straight, slanted)]
    assert lengths[0].max() / lengths[0].min() > 1.9
    assert lengths[1].max() / lengths[1].min() < 1.15


def _loaded_length(tree) -> np.ndarray:
    """Share of slices with a load, summed over the pairs at each mesh position."""
    engagement = tree["engagement"]
    loaded = (engagement.line_load.values[0] > 0.0).mean(axis=1)
    position = np.round(np.mod(engagement.roll_position.values, 1.0), 9) % 1.0
    return np.array([loaded[position == phase].sum() for phase in np.unique(position)])


@pytest.mark.slow
def test_contact_lines_cross_the_helical_flank(helical):
    """Slanted by the base helix angle in the plane of action: profile places differ along the face."""
    lines = plan(helical).loaded_teeth(roll_positions=np.zeros(1)).lines
    row = int(np.argmin(np.abs(lines.roll)))
    pair = pair_of(helical)
    middle = slice(8, 13)
    length = lines.length[row, middle] / (lines.face[1] - lines.face[0])
    np.testing.assert_allclose(length, 1.0 / cos(pair.pinion.base_helix_angle), rtol=0.01)


# ---------------------------------------------------------------- mirror, modification, internal teeth


@pytest.mark.slow
def test_coast_flank_of_one_hand_is_the_drive_flank_of_the_other(helical):
    placement = sw.Placement(offset_mm=0.02, shaft_angle_error_mrad=0.2, pinion_slope_mrad=0.1)
    mirrored = sw.Placement(offset_mm=-0.02, shaft_angle_error_mrad=0.2, pinion_slope_mrad=-0.1)
    drive = sw.loaded_contact(helical, [0.0, 0.4], placement=placement)["engagement"]
    coast = helical.replace({"gear_pair.hand": "left", "operation.loaded_flank": "coast"})
    other = sw.loaded_contact(coast, [0.0, 0.4], placement=mirrored)["engagement"]
    np.testing.assert_allclose(other.line_load, drive.line_load, atol=1e-6)
    same = sw.loaded_contact(coast.replace({"gear_pair.hand": "right"}), [0.0, 0.4], placement=mirrored)["engagement"]
    assert np.abs(same.line_load.values - drive.line_load.values).max() > 10.0


def test_tip_relief_lets_the_load_in_gradually(spur, loaded):
    """Relief of both tips, as deep as the deflection: no load at entry and exit, and a smaller step."""
    relief = {"tip_relief_um": 37.0, "tip_relief_length_mm": 3.0, "relief_shape": "linear"}
    relieved = sw.loaded_contact(
        spur.replace({"effects.modification.pinion": relief, "effects.modification.gear": relief})
    )
    plain, eased = (tree["engagement"].load_share.values[0] for tree in (loaded, relieved))
    assert np.abs(np.diff(eased)).max() < 0.75 * np.abs(np.diff(plain)).max()
    amplitude = [float(np.ptp(tree["mesh_cycle"].transmission_error_loaded.values)) for tree in (loaded, relieved)]
    assert amplitude[1] < 0.8 * amplitude[0]


def test_inclined_axes_press_on_one_end(spur, loaded):
    """Axes askew open the line of action by slope times cos(alpha_wt) per mm of face."""
    slope = 0.2
    tilted = sw.loaded_contact(spur, placement=sw.Placement(pinion_slope_mrad=slope))["engagement"].line_load.values[
        0
    ]
    even = loaded["engagement"].line_load.values[0]
    row = int(np.argmax(even.sum(axis=1)))
    assert abs(even[row, 0] - even[row, -1]) < 1e-6 * even[row].max()
    lean = tilted[row, -2] - tilted[row, 1]
    # teeth that were springs beside each other would lean by the opening over the approach; their ends carry more
    face = loaded["engagement"].face.values
    opening = 1e-3 * slope * np.cos(np.radians(22.44)) * (face[-2] - face[1])
    turned = np.radians(np.abs(loaded["mesh_cycle"].transmission_error_loaded.values).mean() / 3600.0)
    springs = even[row].mean() * opening / (turned * 12.0 * 4.5 * np.cos(np.radians(20.0)))
    assert 1.0 < abs(lean) / springs < 2.0
    other = sw.loaded_contact(spur, placement=sw.Placement(pinion_slope_mrad=-slope))["engagement"].line_load.values[
        0
    ]
    np.testing.assert_allclose(other[row], tilted[row, ::-1], rtol=1e-6)


@pytest.mark.slow
def test_an_internal_pair_presses_less(spur):
    """The concave flank embraces the convex one: lower pressure than an external pair of the same teeth."""
    teeth = {
        "gear_pair.pinion_teeth": 25,
        "gear_pair.pinion_profile_shift": 0.4,
        "gear_pair.centre_distance_mm": None,
    }
    inside, outside = (
        spur.replace(
            {**teeth, "gear_pair.gear_teeth": z2, "gear_pair.gear_profile_shift": x2, "numerics.tooth_pairs": 1}
        )
        for z2, x2 in ((-60, -0.4), (60, -0.4))
    )
    pressures, curvatures = [], []
    for scene in (inside, outside):
        alone = sw.loaded_contact(scene, [0.0])["engagement"]
        pressures.append(float(alone.contact_pressure_max.max()))
        curvatures.append(contact_points(pair_of(scene), np.zeros(1)).curvature[0, 1])
    assert curvatures[0] / curvatures[1] == pytest.approx((60 - 25) / (60 + 25), rel=1e-5)
    assert pressures[0] / pressures[1] == pytest.approx(sqrt(35 / 85), rel=0.02)
    shares = sw.loaded_contact(inside.replace({"numerics.tooth_pairs": "auto"}))["engagement"]
    assert float(shares.load_share.max()) <= 1.0 + 1e-9
    assert np.all(shares.root_stress.values.max(axis=(0, 1)) > 0.0)


# ---------------------------------------------------------------- root stress


def nominal_root_stress(tooth, tip_diameter: float, contact_ratio: float, tangential: float) -> float:
    """F_t/(b m_n) Y_F Y_S with the load at the outer point of single contact (ISO 6336-3:2019, 6.2 and 7.2)."""
    z, x, addendum, rounding = tooth.teeth, tooth.profile_shift, tooth.rack_addendum, tooth.rack_tip_radius
    e = 0.25 * pi * MODULE - addendum * tan(ALPHA) - (1.0 - sin(ALPHA)) * rounding / cos(ALPHA)
    g = (rounding - addendum) / MODULE + x
    h = 2.0 / z * (0.5 * pi - e / MODULE) - pi / 3.0
    angle = pi / 6.0
    for _ in range(60):
        angle = 2.0 * g / z * tan(angle) - h
    chord = z * sin(pi / 3.0 - angle) + sqrt(3.0) * (g / cos(angle) - rounding / MODULE)
    notch = rounding / MODULE + 2.0 * g**2 / (cos(angle) * (z * cos(angle) ** 2 - 2.0 * g))
    base = 0.5 * MODULE * z * cos(ALPHA)
    along = sqrt((0.5 * tip_diameter) ** 2 - base**2) - pi * MODULE * cos(ALPHA) * (contact_ratio - 1.0)
    outer = 2.0 * sqrt(along**2 + base**2)
    pressure = acos(2.0 * base / outer)
    gamma = (0.5 * pi + 2.0 * x * tan(ALPHA)) / z + (tan(ALPHA) - ALPHA) - (tan(pressure) - pressure)
    load = pressure - gamma
    lever = (cos(gamma) - sin(gamma) * tan(load)) * outer / MODULE - z * cos(pi / 3.0 - angle)
    lever = 0.5 * (lever - g / cos(angle) + rounding / MODULE)
    form = 6.0 * lever * cos(load) / (chord**2 * cos(ALPHA))
    slender, sharp = chord / lever, chord / (2.0 * notch)
    correction = (1.2 + 0.13 * slender) * sharp ** (1.0 / (1.21 + 2.3 / slender))
    return tangential / (WIDTH * MODULE) * form * correction


def test_root_stress_against_iso_6336_3(spur):
    """Within 10 %: the standard's Y_S is itself a fit, to some 5 %, of finite elements at the 30 degree tangent."""
    pair, table = pair_of(spur), spur.gear_pair
    first, last = (length / pair.base_pitch for length in pair.path_limits)
    # outer point of single contact: of the pinion when the pair before it has just left, of the gear at its start
    outer_pinion, outer_gear = 1.0 - first, -last - 1.0
    scene = spur.replace({"numerics.tooth_pairs": 1})
    engagement = sw.loaded_contact(scene, [outer_gear, outer_pinion])["engagement"]
    tangential = 2e3 * spur.operation.pinion_torque_Nm / (MODULE * 16)
    for body, roll, tip in (
        (0, outer_pinion, table.pinion_tip_diameter_mm),
        (1, outer_gear, table.gear_tip_diameter_mm),
    ):
        row = int(np.argmin(np.abs(engagement.roll_position.values - roll)))
        assert engagement.roll_position.values[row] == pytest.approx(roll, abs=1e-9)
        found = float(engagement.root_stress[0, row, body])
        tooth = (pair.pinion, pair.gear)[body]
        expected = nominal_root_stress(tooth, tip, pair.transverse_contact_ratio, tangential)
        print(f"{('pinion', 'gear')[body]}: {found:.1f} MPa, ISO 6336-3 method B {expected:.1f} MPa")
        assert found == pytest.approx(expected, rel=0.10)


def exchanged(scene: sw.Scene) -> sw.Scene:
    """The spur pair with its gear driving: the same flanks, told from the other side."""
    pair = scene.gear_pair
    changes = {"operation.pinion_torque_Nm": scene.operation.pinion_torque_Nm * pair.gear_teeth / pair.pinion_teeth}
    for name in ("teeth", "profile_shift", "tip_diameter_mm", "rack_tip_radius_mm"):
        changes[f"gear_pair.pinion_{name}"] = getattr(pair, f"gear_{name}")
        changes[f"gear_pair.gear_{name}"] = getattr(pair, f"pinion_{name}")

    def root(body):
        teeth, shift = getattr(pair, f"{body}_teeth"), getattr(pair, f"{body}_profile_shift")
        return pair.normal_module_mm * (0.5 * teeth + shift) - getattr(pair, f"{body}_rack_addendum_mm")

    changes["gear_pair.pinion_bore_radius_mm"] = root("gear") - pair.gear_rim_thickness_mm
    changes["gear_pair.gear_rim_thickness_mm"] = root("pinion") - pair.pinion_bore_radius_mm
    return scene.replace(changes)


@pytest.mark.slow
def test_a_pair_told_from_the_other_side_bears_alike():
    """Where its tip edges take the load over, one of them does some 0.002 base pitches sooner: see the README."""
    scene = sw.load_scene("spur_fzg_c").replace({"wear": None, "numerics.face_slices": 11, "numerics.harmonics": 9})
    rolls = [-0.75, -0.7, -0.4, 0.0, 0.4, 0.66, 0.68, 0.7, 0.71, 0.72, 0.73]
    one = sw.loaded_contact(scene, rolls)["engagement"].to_dataset().isel(wear_step=0)
    one = one.sel(roll_position=rolls, method="nearest")
    other = sw.loaded_contact(exchanged(scene), [-roll for roll in rolls[::-1]])["engagement"].to_dataset()
    other = other.isel(wear_step=0).sel(roll_position=[-roll for roll in rolls], method="nearest")
    np.testing.assert_allclose(other.load_share.values[1:], one.load_share.values[1:], atol=1e-3)
    assert other.load_share.values[0] == pytest.approx(one.load_share.values[0], abs=0.015)  # an edge begins to bear
    np.testing.assert_allclose(other.root_stress.values[1:, ::-1], one.root_stress.values[1:], rtol=2e-2)
    greatest = [float(told.contact_pressure_max_edge.max()) for told in (one, other)]
    assert greatest[1] == pytest.approx(greatest[0], rel=0.01)
    rising = np.interp(0.7, one.roll_position.values, one.contact_pressure_max_edge.values)
    sooner = np.interp(
        rising, other.contact_pressure_max_edge.values[-5:], -other.roll_position.values[-5:]
    )  # where the other reaches that pressure
    assert sooner == pytest.approx(0.7, abs=0.004)
