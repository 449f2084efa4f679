"""Properties of the tooth geometry that hold for any modest proportions."""

from dataclasses import dataclass, replace
from math import acos, cos, pi, radians, tan

import numpy as np
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from semiwear.arrays import FloatArray
from semiwear.geometry.face_gear import FaceGearTooth
from semiwear.geometry.involute import InvoluteTooth

# At the limit itself the height is stationary along the profile, so that its inverse keeps half the digits only.
CLEAR_OF_UNDERCUT = 1.002


@dataclass(frozen=True)
class Case:
    """A gear with radii that lie between its limits, and profile coordinates on its flank there."""

    gear: FaceGearTooth
    radius: FloatArray
    profile: FloatArray


@st.composite
def gears(draw: st.DrawFn) -> FaceGearTooth:
    module = draw(st.floats(0.5, 10.0))
    return FaceGearTooth(
        shaper_teeth=draw(st.integers(17, 60)) + draw(st.integers(1, 3)),
        gear_teeth=draw(st.integers(80, 300)),
        module=module,
        pressure_angle=radians(draw(st.floats(18.0, 28.0))),
        gear_addendum=draw(st.floats(0.5, 0.9)) * module,
        shaper_addendum=draw(st.floats(1.0, 1.2)) * module,
        shaper_tip_radius=draw(st.floats(0.0, 0.1)) * module,
        rim_thickness=2.5 * module,
    )


def inner_limit(gear: FaceGearTooth) -> float:
    """Undercut limit, wherever it lies."""
    return max(gear.singular_radii(gear.crest_roll_angle), default=0.0)


@st.composite
def cases(draw: st.DrawFn, clear: float = CLEAR_OF_UNDERCUT) -> Case:
    gear = draw(gears())
    assume(gear.crest_half_width >= 0.0)
    inner = clear * inner_limit(gear)
    outer = gear.pointing_radius()
    assume(inner < outer)
    shares = draw(st.lists(st.floats(0.0, 1.0), min_size=3, max_size=3))
    radius = np.repeat(inner + (outer - inner) * np.array(shares), 5)
    begin = float(gear.profile_from_roll(0.0))
    profile = gear.root_profile + (0.98 * begin - gear.root_profile) * np.tile(np.linspace(0.0, 1.0, 5), 3)
    return Case(gear, radius, profile)


@st.composite
def pinions(draw: st.DrawFn) -> InvoluteTooth:
    module = draw(st.floats(0.5, 10.0))
    teeth = draw(st.integers(17, 60))
    tooth = InvoluteTooth(
        teeth=teeth,
        module=module,
        pressure_angle=radians(draw(st.floats(18.0, 28.0))),
        addendum=draw(st.floats(0.5, 1.0)) * module,
        rack_addendum=draw(st.floats(0.6, 1.25)) * module,
        rack_tip_radius=draw(st.floats(0.0, 0.25)) * module,
        bore_radius=0.2 * module * teeth,
        profile_shift=draw(st.floats(-0.4, 0.4)) * module,
    )
    assume(tooth.form_roll_angle > 0.0)
    return tooth


# ---- the gear


def next_to_the_undercut_limit() -> Case:
    gear = FaceGearTooth(
        shaper_teeth=32,
        gear_teeth=80,
        module=1.0,
        pressure_angle=radians(18.0),
        gear_addendum=0.5,
        shaper_addendum=1.0,
        shaper_tip_radius=0.0,
        rim_thickness=2.5,
    )
    return Case(gear, np.full(5, 1.01 * gear.undercut_radius()), np.linspace(gear.root_profile, 0.7, 5))


@settings(max_examples=40)
@example(next_to_the_undercut_limit())
@given(cases())
def test_profile_from_height_inverts_height(case: Case) -> None:
    height = case.gear.height(case.radius, case.profile)
    profile = case.gear.profile_from_height(case.radius, height)
    np.testing.assert_allclose(profile, case.profile, rtol=0.0, atol=1e-8 * case.gear.module)


@settings(max_examples=40)
@given(cases(clear=1.0))
def test_points_lie_on_the_radius_and_at_the_height(case: Case) -> None:
    points, normals = case.gear.points(case.radius, case.profile)
    assert np.all(np.isfinite(points)) and np.all(np.isfinite(normals))
    np.testing.assert_allclose(np.hypot(points[:, 0], points[:, 2]), case.radius, rtol=1e-12)
    height = points[:, 1] + case.gear.shaper_pitch_radius
    np.testing.assert_allclose(height, case.gear.height(case.radius, case.profile), atol=1e-11 * case.radius[0])


@settings(max_examples=40)
@given(cases())
def test_normals_are_unit_and_normal(case: Case) -> None:
    gear, step = case.gear, 1e-3 * case.gear.module
    # well inside, so that the differences stay on the flank
    profile = case.profile - 2.0 * step * np.sign(case.profile)
    _, normals = gear.points(case.radius, profile)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=-1), 1.0, rtol=1e-12)

    def along(radius_step: float, profile_step: float) -> FloatArray:
        ahead, _ = gear.points(case.radius + radius_step, profile + profile_step)
        back, _ = gear.points(case.radius - radius_step, profile - profile_step)
        return (ahead - back) / np.linalg.norm(ahead - back, axis=-1, keepdims=True)

    for tangent in (along(step, 0.0), along(0.0, step)):
        np.testing.assert_allclose(np.sum(normals * tangent, axis=-1), 0.0, atol=2e-5)


@settings(max_examples=40)
@given(gears())
def test_the_tip_plane_narrows_outwards_to_a_point(gear: FaceGearTooth) -> None:
    pointing = gear.pointing_radius()
    assume(CLEAR_OF_UNDERCUT * inner_limit(gear) < gear.pitch_radius)
    radii = np.linspace(gear.pitch_radius, pointing, 7)
    half = [gear.half_thickness(float(radius), gear.gear_addendum) for radius in radii]
    assert np.all(np.diff(half) < 0.0)
    assert abs(half[-1]) < 1e-8 * gear.module
    # the involute of the shaper keeps the pitch plane divided evenly at the pitch radius
    assert abs(gear.half_thickness(gear.pitch_radius, 0.0) - 0.25 * pi * gear.module) < 1e-9 * gear.module


@settings(max_examples=40)
@given(cases(clear=1.0))
def test_nothing_is_undefined_between_the_limits(case: Case) -> None:
    gear = case.gear
    for radius in case.radius[::5]:
        fillet = gear.fillet(float(radius))
        assert np.all(np.isfinite(fillet))
        np.testing.assert_allclose(np.hypot(fillet[:, 0], fillet[:, 2]), radius, rtol=1e-12)
        np.testing.assert_allclose(fillet[-1, 1], -gear.shaper_crest_radius, rtol=1e-12)
        end, _ = gear.points(np.array(radius), np.array(gear.root_profile))
        np.testing.assert_allclose(fillet[0], end, rtol=0.0, atol=1e-8 * gear.pitch_radius)


# ---- the pinion


@settings(max_examples=40)
@given(pinions(), st.floats(0.0, 1.0))
def test_pinion_profile_coordinates_agree(pinion: InvoluteTooth, share: float) -> None:
    roll = pinion.form_roll_angle + share * (pinion.tip_roll_angle - pinion.form_roll_angle)
    profile = pinion.profile_from_roll(roll)
    np.testing.assert_allclose(pinion.roll_from_profile(profile), roll, atol=1e-12)


@given(pinions())
def test_pinion_thickness_and_pitch_are_those_of_the_standard(pinion: InvoluteTooth) -> None:
    """ISO 21771: s = m (pi/2 + 2 x tan(alpha)), s_a/d_a = s/d + inv(alpha) - inv(alpha_a), p_b = pi m cos(alpha)."""
    alpha, at_tip = pinion.pressure_angle, acos(pinion.base_radius / pinion.tip_radius)
    thickness = 0.5 * pi * pinion.module + 2.0 * pinion.profile_shift * tan(alpha)
    at_pitch = -2.0 * pinion.pitch_radius * pinion.polar_angle(np.array(tan(alpha)))
    np.testing.assert_allclose(at_pitch, thickness, rtol=1e-10)
    half = 0.5 * thickness / pinion.pitch_radius + (tan(alpha) - alpha) - (tan(at_tip) - at_tip)
    np.testing.assert_allclose(pinion.tip_half_thickness, half * pinion.tip_radius, atol=1e-10 * pinion.pitch_radius)
    np.testing.assert_allclose(pinion.base_pitch, pi * pinion.module * cos(alpha), rtol=1e-12)


@given(pinions())
def test_a_rack_as_deep_as_the_undercut_depth_generates_down_to_the_base_circle(pinion: InvoluteTooth) -> None:
    deeper = pinion.undercut_depth - pinion.straight_depth
    limit = replace(pinion, rack_addendum=pinion.rack_addendum + deeper)
    assert abs(limit.form_roll_angle) < 1e-12


@settings(max_examples=40)
@given(pinions())
def test_pinion_outline_is_continuous_and_falls_to_the_root(pinion: InvoluteTooth) -> None:
    section = pinion.section()
    np.testing.assert_allclose(pinion.fillet()[0], section.flank[-1], rtol=0.0, atol=1e-10 * pinion.pitch_radius)
    flank_radius, fillet_radius = np.hypot(*section.flank.T), np.hypot(*section.fillet.T)
    assert np.all(np.diff(flank_radius) < 0.0)
    assert np.all(np.diff(fillet_radius) < 1e-12 * pinion.pitch_radius)
    np.testing.assert_allclose(flank_radius[0], pinion.tip_radius, rtol=1e-12)
    np.testing.assert_allclose(fillet_radius[-1], pinion.root_radius, rtol=1e-12)
    # the tooth grows thicker towards its root
    angle = np.arctan2(*np.vstack([section.flank, section.fillet]).T)
    assert np.all(np.diff(angle) > -1e-12)
