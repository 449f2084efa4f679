"""Cylindrical pairs: teeth, meshing and unloaded contact against ISO 21771 and against definitions."""

from math import acos, atan, cos, pi, radians, sin, sqrt, tan

import numpy as np
import pytest
from scipy.optimize import minimize

import semiwear as sw
from semiwear.meshing.cylindrical_pair import CylindricalMesh
from semiwear.meshing.flank_pair import DRIVEN, DRIVING
from semiwear.meshing.tooth_contact import contact_points, unloaded_contact
from semiwear.scene import CylindricalPair, Placement

SPUR = {"pinion_teeth": 16, "gear_teeth": 24, "pinion_profile_shift": 0.1817, "gear_profile_shift": 0.1715}
KINDS = {
    "spur": SPUR | {"centre_distance_mm": 91.5},
    "helical": SPUR | {"helix_angle_deg": 20.0, "hand": "left"},
    "internal": {"pinion_teeth": 25, "gear_teeth": -60, "pinion_profile_shift": 0.4, "gear_profile_shift": -0.4},
    "internal helical": {
        "pinion_teeth": 25,
        "gear_teeth": -70,
        "pinion_profile_shift": 0.4,
        "gear_profile_shift": -0.5,
        "helix_angle_deg": 15.0,
    },
    "wide": {"pinion_teeth": 20, "gear_teeth": 61, "helix_angle_deg": 30.0, "pinion_face_width_mm": 60.0},
}


def mesh(placement: Placement | None = None, **fields: object) -> CylindricalMesh:
    plain = {"type": "cylindrical", "normal_module_mm": 4.5, "pressure_angle_deg": 20.0, "pinion_face_width_mm": 14.0}
    return CylindricalMesh(CylindricalPair(**(plain | fields)), placement or Placement())  # type: ignore[arg-type]


class Iso:
    """The pair's quantities by the formulas of ISO 21771, signs included: z2 and a are negative inside."""

    def __init__(self, table: CylindricalPair) -> None:
        t, beta, alpha = table, radians(table.helix_angle_deg), radians(table.pressure_angle_deg)
        self.z1, self.z2 = t.pinion_teeth, t.gear_teeth
        self.side = 1 if self.z2 > 0 else -1
        self.alpha_t = atan(tan(alpha) / cos(beta))
        self.beta_b = atan(tan(beta) * cos(self.alpha_t))
        module_t = t.normal_module_mm / cos(beta)
        self.rb1, self.rb2 = (0.5 * module_t * z * cos(self.alpha_t) for z in (self.z1, self.z2))
        self.a = self.side * t.centre_distance_mm
        self.alpha_wt = acos((self.rb1 + self.rb2) / self.a)
        self.rw1, self.rw2 = self.rb1 / cos(self.alpha_wt), self.rb2 / cos(self.alpha_wt)
        self.pbt = pi * module_t * cos(self.alpha_t)
        ra1, ra2 = 0.5 * t.pinion_tip_diameter_mm, 0.5 * t.gear_tip_diameter_mm
        tips = sqrt(ra1**2 - self.rb1**2) + self.side * sqrt(ra2**2 - self.rb2**2)
        self.eps_alpha = (tips - self.a * sin(self.alpha_wt)) / self.pbt
        self.eps_beta = t.pinion_face_width_mm * sin(beta) / (pi * t.normal_module_mm)

    def on_path(self, travel: np.ndarray) -> np.ndarray:
        """Points of the line of action at z = 0, at distances l from the pitch point towards entry."""
        along = np.stack([travel * cos(self.alpha_wt), travel * sin(self.alpha_wt), 0.0 * travel], axis=-1)
        return along + np.array([0.0, -self.rw1, 0.0])

    def curvature(self, travel: np.ndarray) -> np.ndarray:
        """Relative curvature in the normal section at l, the distance from the pitch point towards entry [1/mm]."""
        rho1 = self.rw1 * sin(self.alpha_wt) - travel
        rho2 = self.rw2 * sin(self.alpha_wt) + travel
        return cos(self.beta_b) * (1.0 / rho1 + 1.0 / rho2)


@pytest.fixture(params=list(KINDS), scope="module")
def kind(request):
    return mesh(**KINDS[request.param])


def test_the_figures_of_the_fzg_type_c_gears():
    """Tip diameters 82.46 and 118.36 mm, working pressure angle 22.44 degrees, contact ratio 1.44."""
    table = sw.load_scene("spur_fzg_c").gear_pair
    assert isinstance(table, CylindricalPair)
    pair = CylindricalMesh(table, Placement())
    assert table.pinion_tip_diameter_mm == pytest.approx(82.46, abs=0.005)
    assert table.gear_tip_diameter_mm == pytest.approx(118.36, abs=0.006)
    assert np.degrees(table.working_pressure_angle) == pytest.approx(22.44, abs=0.005)
    assert pair.working_radii == pytest.approx((36.6, 54.9), rel=1e-12)
    assert pair.transverse_contact_ratio == pytest.approx(1.44, abs=0.005)
    # the shifts of type A, 0.8532 and -0.5, have the same sum and so the same centre distance
    assert table.pinion_profile_shift + table.gear_profile_shift == pytest.approx(0.8532 - 0.5, abs=1e-9)


@pytest.fixture(scope="module")
def contact(kind):
    return unloaded_contact(kind, 15)


@pytest.mark.slow
def test_contact_ratios(kind, contact):
    iso = Iso(kind.table)
    assert kind.transverse_contact_ratio == pytest.approx(iso.eps_alpha, rel=1e-9)
    assert kind.overlap_ratio == pytest.approx(iso.eps_beta, abs=1e-9)
    assert kind.base_pitch == pytest.approx(iso.pbt, rel=1e-12)
    # found again by following the contact, without the formula: total contact ratio
    assert contact.contact_ratio == pytest.approx(iso.eps_alpha + iso.eps_beta, abs=2e-6)


@pytest.mark.slow
def test_path_of_contact_is_the_straight_line(kind, contact):
    iso = Iso(kind.table)
    # places are found by differences over 1/2000 of the tooth height, to some 1e-5 mm where the flank bends most
    x, y, z = contact.points.position.T
    travel = x / cos(iso.alpha_wt)
    np.testing.assert_allclose(y + iso.rw1, travel * sin(iso.alpha_wt), atol=2e-5)
    hand = 1.0 if kind.table.hand == "right" else -1.0
    np.testing.assert_allclose(travel, -iso.pbt * contact.roll + hand * z * tan(iso.beta_b), atol=5e-5)


def test_no_transmission_error(kind):
    """Nor when the centre distance changes, or a spur pinion is moved along its axis."""
    for placement in (Placement(), Placement(axial_gear_mm=0.05), Placement(offset_mm=0.03, axial_pinion_mm=0.2)):
        points = contact_points(CylindricalMesh(kind.table, placement), np.linspace(-0.45, 0.45, 13))
        assert points.inside.all()
        assert np.ptp(points.separation) * kind.arcsec_per_mm < 1e-4  # arcsec


def test_sliding_velocity(kind):
    """(omega_1 -+ omega_2) times the distance from the pitch point (ISO 21771, 5.6), at one radian per unit time."""
    iso = Iso(kind.table)
    travel = np.linspace(-0.4, 0.4, 9) * iso.pbt
    position = iso.on_path(travel)
    expected = np.abs(travel) * (1.0 + iso.z1 / iso.z2)
    np.testing.assert_allclose(np.linalg.norm(kind.sliding(position), axis=1), expected, rtol=1e-9, atol=1e-12)


def test_the_line_of_action_is_where_flanks_meet(kind):
    """At l the driven flank is at the roll angle tan(alpha_wt) + l/r_b2: no separation, and one normal."""
    iso = Iso(kind.table)
    travel = np.linspace(-0.4, 0.4, 9) * iso.pbt
    profile = 0.5 * iso.rb2 * ((tan(iso.alpha_wt) + travel / iso.rb2) ** 2 - tan(iso.alpha_wt) ** 2)
    met = kind.meeting(np.zeros(9), profile, -travel / iso.pbt)
    np.testing.assert_allclose(met.separation, 0.0, atol=1e-12)
    np.testing.assert_allclose(met.position, iso.on_path(travel), atol=1e-9)
    hand = 1.0 if kind.table.hand == "right" else -1.0
    normal = np.array([cos(iso.alpha_wt), sin(iso.alpha_wt), -hand * tan(iso.beta_b)]) * cos(iso.beta_b)
    np.testing.assert_allclose(met.normal, np.tile(normal, (9, 1)), atol=1e-12)
    # neither body runs into the other
    np.testing.assert_allclose(np.sum(kind.sliding(met.position) * met.normal, axis=1), 0.0, atol=1e-9)


def test_radii_of_curvature(kind):
    iso = Iso(kind.table)
    points = contact_points(kind, np.linspace(-0.4, 0.4, 9))
    travel = points.position[:, 0] / cos(iso.alpha_wt)
    # differences of fourth order over 1/500 and 1/250 of the tooth height
    np.testing.assert_allclose(points.curvature[:, 1], iso.curvature(travel), rtol=1e-6)
    assert np.abs(points.curvature[:, 0]).max() < 1e-6 * points.curvature[:, 1].min()


def test_lever_and_transmission(kind):
    iso = Iso(kind.table)
    lever = iso.rb1 * cos(iso.beta_b)
    np.testing.assert_allclose(kind.lever_arm(np.zeros((2, 3))), lever, rtol=1e-12)
    assert kind.arcsec_per_mm == pytest.approx(3600.0 * 180.0 / pi / (abs(iso.rb2) * cos(iso.beta_b)), rel=1e-12)
    assert kind.driving_meshes == pytest.approx(abs(iso.z2 / iso.z1))


def test_default_centre_distance_leaves_no_backlash(kind):
    """Thicknesses on the working pitch cylinders fill the pitch; more distance opens the teeth (ISO 21771, 5.4)."""
    free = mesh(**{**_fields(kind.table), "centre_distance_mm": None})
    pitch = 2.0 * pi * free.working_radii[0] / free.pinion.teeth
    filled = sum(
        2.0 * tooth.half_thickness(radius)
        for tooth, radius in zip((free.pinion, free.gear), free.working_radii, strict=True)
    )
    assert filled == pytest.approx(pitch, rel=1e-9)


def _fields(table: CylindricalPair) -> dict[str, object]:
    return {name: getattr(table, name) for name in KINDS["spur"] | KINDS["wide"]}


@pytest.mark.parametrize("body", [DRIVING, DRIVEN])
def test_heights_and_pitch_profile(kind, body):
    height, radius = kind.flank_place(body, np.zeros(3), np.array([-1.0, 0.0, 1.0]))
    working = kind.working_radii[body]
    side = (kind.pinion, kind.gear)[body].side
    assert height[1] == pytest.approx(0.0, abs=1e-12)
    assert np.all(np.diff(height) > 0.0)
    np.testing.assert_allclose(radius, working + side * height, rtol=1e-12)
    if body == DRIVEN:
        np.testing.assert_allclose(kind.profile_at(np.zeros(3), height), [-1.0, 0.0, 1.0], atol=1e-9)
        assert np.all(kind.pitch_profile(np.zeros(3)) == 0.0)


@pytest.mark.parametrize("teeth", [12, 14, 16])
def test_least_profile_shift_against_undercut(teeth):
    """A rack whose straight flank is one module deep: x = 1 - z sin^2(alpha)/2 (ISO 21771; 17 teeth need none)."""
    fields = {
        "pinion_teeth": teeth,
        "gear_teeth": 40,
        "pinion_rack_tip_radius_mm": 0.0,
        "pinion_rack_addendum_mm": 4.5,
    }
    least = 1.0 - 0.5 * teeth * sin(radians(20.0)) ** 2
    below, above = (mesh(pinion_profile_shift=least + d, **fields).pinion.form_roll_angle for d in (-1e-6, 1e-6))
    assert below < 0.0 < above


# ---------------------------------------------------------------- the separation, by brute force


def helicoid(
    base: float, theta: np.ndarray, turn: np.ndarray, z: np.ndarray, tangent: float, mirror: int
) -> np.ndarray:
    """Points of a screw surface: an involute by unwinding a string, turned by z times tan(beta_b)/r_b.

    The string is taut from the base circle; `mirror` -1 winds the other way. Angle 0 is -y, positive towards +x.
    """
    start = turn + z * tangent / base
    radial = np.stack([np.sin(start + mirror * theta), -np.cos(start + mirror * theta)], axis=-1)
    along = mirror * np.stack([np.cos(start + mirror * theta), np.sin(start + mirror * theta)], axis=-1)
    return np.concatenate([base * (radial - theta[..., None] * along), z[..., None]], axis=-1)


@pytest.mark.parametrize(
    "placement",
    [
        pytest.param(Placement(), marks=pytest.mark.slow, id="aligned"),
        pytest.param(Placement(0.1, -0.2, 0.05, 1.5, -2.0), id="misplaced"),
    ],
)
def test_separation_is_the_distance_between_the_surfaces(kind, placement):
    pair = CylindricalMesh(kind.table, placement)
    iso = Iso(kind.table)
    hand = 1.0 if kind.table.hand == "right" else -1.0
    inv = tan(iso.alpha_wt) - iso.alpha_wt
    tangent = hand * tan(iso.beta_b)
    turns = np.array([1e-3 * placement.shaft_angle_error_mrad, 1e-3 * placement.pinion_slope_mrad])
    c, s = np.cos(turns), np.sin(turns)
    rotation = np.array([[1, 0, 0], [0, c[0], -s[0]], [0, s[0], c[0]]]) @ np.array(
        [[c[1], 0, s[1]], [0, 1, 0], [-s[1], 0, c[1]]]
    )
    pitch_point = np.array([0.0, -iso.rw1, 0.0])
    shift = np.array([placement.offset_mm, placement.axial_gear_mm, placement.axial_pinion_mm])
    random = np.random.default_rng(7)
    for _ in range(4):
        roll, face = random.uniform(-0.4, 0.4), random.uniform(-5.0, 5.0)
        place = contact_points(kind, np.array([roll]))
        profile = float(place.profile[0]) + random.uniform(-0.6, 0.6)
        met = pair.meeting(np.array(face), np.array(profile), np.array(roll))
        # the gear's point lies on its own screw surface, which passes the pitch point at roll 0
        base = abs(iso.rb2)
        theta = float(np.sqrt(tan(iso.alpha_wt) ** 2 + 2.0 * iso.side * profile / base))
        turn = -2.0 * pi / abs(iso.z2) * roll
        if iso.side > 0:
            # seen from the gear the pitch point is at +y: the picture upside down
            own = helicoid(base, np.array(theta), np.array(inv + turn), np.array(face), tangent, -1)
            point = own * [1.0, -1.0, 1.0] + [0.0, -iso.a, 0.0]
        else:
            point = helicoid(base, np.array(theta), np.array(turn - inv), np.array(face), tangent, 1)
            point = point + np.array([0.0, -iso.a, 0.0])
        np.testing.assert_allclose(met.position, point, atol=1e-9)
        # distance to the pinion's surface, with the point in the pinion's frame
        local = rotation.T @ (point - shift - pitch_point) + pitch_point
        pinion_turn = np.array(-2.0 * pi / iso.z1 * roll - inv)

        def away(at: np.ndarray, local: np.ndarray = local, pinion_turn: np.ndarray = pinion_turn) -> float:
            surface = helicoid(iso.rb1, np.array(abs(at[0])), pinion_turn, np.array(at[1]), tangent, 1)
            return float(np.sum((surface - local) ** 2))

        start = [sqrt(max(np.hypot(local[0], local[1]) ** 2 / iso.rb1**2 - 1.0, 0.01)), local[2]]
        options = {"xatol": 1e-11, "fatol": 1e-18, "maxiter": 4000, "maxfev": 4000}
        found = minimize(away, start, method="Nelder-Mead", options=options)
        assert abs(float(met.separation)) == pytest.approx(sqrt(found.fun), abs=2e-7)


# ---------------------------------------------------------------- sections


def rack_region(point: np.ndarray, module: float, alpha: float, addendum: float, rounding: float) -> np.ndarray:
    """Depth of points (distance along the pitch line, height above the reference line) in a rack's tooth [mm].

    The rack tooth points down (-y) and is centred on x = 0; negative outside.
    """
    x, y = np.abs(point[..., 0]), point[..., 1]
    centre = np.array(
        [0.25 * pi * module - (addendum - rounding) * tan(alpha) - rounding / cos(alpha), rounding - addendum]
    )
    flank = (centre[0] - x) * cos(alpha) + (y - centre[1]) * sin(alpha) + rounding
    corner = rounding - np.hypot(x - centre[0], y - centre[1])
    crest = y + addendum
    # nearest boundary: the straight flank above the tangent point, the arc beside the corner, the crest below
    along = (x - centre[0]) * sin(alpha) + (y - centre[1]) * cos(alpha)
    return np.where(x <= centre[0], np.minimum(crest, flank), np.where(along >= 0.0, flank, corner))


@pytest.mark.parametrize(("teeth", "shift"), [(16, 0.1817), (24, -0.2), (12, 0.5), (40, 0.0)])
def test_a_rack_that_rolls_generates_flank_and_fillet(teeth, shift):
    """No position of the rack cuts into the outline, and each of its points is touched by one."""
    module, alpha = 4.5, radians(20.0)
    pair = mesh(pinion_teeth=teeth, gear_teeth=60, pinion_profile_shift=shift)
    section = pair.prism_body(DRIVING).sections[0]
    radius = 0.5 * module * teeth
    outline = np.vstack([section.flank[10:], section.fillet])
    turn = np.linspace(-1.2, 1.2, 8001)[:, None]
    # the tooth space beside the tooth on +y is centred at pi/z: turn it to +y, then roll the gear under the rack
    angle = np.arctan2(outline[:, 0], outline[:, 1]) - pi / teeth + turn
    r = np.hypot(*outline.T)
    points = np.stack([r * np.sin(angle) - radius * turn, r * np.cos(angle) - radius - shift * module], axis=-1)
    depth = rack_region(points, module, alpha, 1.25 * module, 0.38 * module).max(axis=0)
    assert depth.max() < 1e-4
    assert depth.min() > -1e-4


@pytest.mark.parametrize("body", [DRIVING, DRIVEN])
def test_sections_are_smooth_and_carry_the_profile_coordinate(kind, body):
    section = kind.prism_body(body).sections[0]
    np.testing.assert_allclose(section.fillet[0], section.flank[-1], atol=1e-12)
    first, second = section.flank[-1] - section.flank[-2], section.fillet[1] - section.fillet[0]
    cosine = first @ second / np.linalg.norm(first) / np.linalg.norm(second)
    assert cosine > cos(radians(5.0))  # tangent, but for the length of the steps
    assert np.all(section.fillet[:, 0] > 0.0)
    steps = np.diff(section.flank_profile)
    assert np.all(steps < 0.0)
    borders = kind.borders(np.zeros(1), sharp=True)
    root = float(borders.root[0]) if body == DRIVEN else borders.driving_root
    tip = float(borders.tip[0]) if body == DRIVEN else borders.driving_tip
    assert section.flank_profile[0] == pytest.approx(tip, abs=1e-6)
    assert section.flank_profile[-1] == pytest.approx(root, abs=0.12)
    # as high as the tooth is, and as thick at its tip
    tooth = (kind.pinion, kind.gear)[body]
    thickness = tooth.half_thickness(tooth.tip_radius) * cos(tooth.helix_angle)
    assert section.flank[0, 0] == pytest.approx(thickness, rel=0.1)


def test_spur_sections_are_those_of_the_transverse_plane():
    pair = mesh(**KINDS["spur"])
    for body, tooth in ((DRIVING, pair.pinion), (DRIVEN, pair.gear)):
        section = pair.prism_body(body).sections[0]
        radius = np.hypot(*section.flank.T)
        expected = [tooth.half_thickness(r) / r for r in radius]
        np.testing.assert_allclose(np.arctan2(section.flank[:, 0], section.flank[:, 1]), expected, atol=1e-12)
        _, at = pair.flank_place(body, np.zeros(radius.size), section.flank_profile)
        np.testing.assert_allclose(at, radius, atol=1e-5)
        assert np.hypot(*section.fillet[-1]) == pytest.approx(tooth.root_radius, rel=1e-12)
