"""Flanks and fillets against cutters that are swept numerically, and the figures of the design.

The cutter here is nothing but its outline (involute, circle, straight line) and rigid rotations: a shaper that
turns by tau about +z while the gear turns by q tau about +y; a rack that rolls on the pinion's pitch circle.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import acos, atan, atan2, cos, hypot, pi, radians, sin, tan

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq, minimize_scalar

from semiwear.arrays import FloatArray
from semiwear.geometry.face_gear import FaceGearTooth
from semiwear.geometry.involute import InvoluteTooth

MODULE, ALPHA = 6.35, radians(25.0)
GEAR = FaceGearTooth(
    shaper_teeth=28,
    gear_teeth=160,
    module=MODULE,
    pressure_angle=ALPHA,
    gear_addendum=MODULE,
    shaper_addendum=1.25 * MODULE,
    shaper_tip_radius=0.2 * MODULE,
    rim_thickness=2.5 * MODULE,
)
# another proportion: coarse ratio, low pressure angle, stub teeth
OTHER_GEAR = FaceGearTooth(
    shaper_teeth=33,
    gear_teeth=90,
    module=2.0,
    pressure_angle=radians(20.0),
    gear_addendum=1.6,
    shaper_addendum=2.2,
    shaper_tip_radius=0.3,
    rim_thickness=5.0,
)
PINION = InvoluteTooth(
    teeth=25,
    module=MODULE,
    pressure_angle=ALPHA,
    addendum=MODULE,
    rack_addendum=1.25 * MODULE,
    rack_tip_radius=0.3 * MODULE,
    bore_radius=50.0,
)
OTHER_PINION = InvoluteTooth(
    teeth=41,
    module=2.0,
    pressure_angle=radians(20.0),
    addendum=2.0,
    rack_addendum=2.5,
    rack_tip_radius=0.76,
    bore_radius=20.0,
)
FACES = {GEAR: (480.0, 494.0, 508.0, 533.0, 560.0), OTHER_GEAR: (87.0, 90.0, 94.0, 97.0)}
GEARS = pytest.mark.parametrize("gear", [GEAR, OTHER_GEAR], ids=["shipped", "other"])
PINIONS = pytest.mark.parametrize("pinion", [PINION, OTHER_PINION], ids=["shipped", "other"])


def about_z(angle: float, v: FloatArray) -> FloatArray:
    c, s = cos(angle), sin(angle)
    return np.array([c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]])


def about_y(angle: float, v: FloatArray) -> FloatArray:
    c, s = cos(angle), sin(angle)
    return np.array([c * v[0] + s * v[2], v[1], -s * v[0] + c * v[2]])


# ---- the shaper: one tooth centred on -y, the outline on its -x side


@dataclass(frozen=True)
class Shaper:
    """Outline of a shaper tooth, from numbers of teeth, module and pressure angle alone."""

    teeth: int
    ratio: float
    pitch_radius: float
    base_radius: float
    crest_radius: float
    tip_radius: float
    phase: float

    @classmethod
    def of(cls, gear: FaceGearTooth) -> "Shaper":
        pitch = 0.5 * gear.module * gear.shaper_teeth
        alpha = gear.pressure_angle
        # half the tooth on the pitch circle, pi/(2 N), puts the involute's origin this far from the centre line
        phase = -(0.5 * pi / gear.shaper_teeth + tan(alpha) - alpha)
        return cls(
            gear.shaper_teeth,
            gear.shaper_teeth / gear.gear_teeth,
            pitch,
            pitch * cos(alpha),
            pitch + gear.shaper_addendum,
            gear.shaper_tip_radius,
            phase,
        )

    def involute(self, roll: float) -> FloatArray:
        """End of a taut string that is unwound from the base circle, which it leaves at `roll + phase`."""
        leave = roll + self.phase
        from_base = self.base_radius * np.array([sin(leave), -cos(leave)])
        return from_base - self.base_radius * roll * np.array([cos(leave), sin(leave)])

    def form(self) -> tuple[float, FloatArray]:
        """Roll angle at the end of the involute and centre of the rounding, which also touches the crest circle."""

        def centre(roll: float) -> FloatArray:
            leave = roll + self.phase
            return self.involute(roll) + self.tip_radius * np.array([cos(leave), sin(leave)])

        def excess(roll: float) -> float:
            return float(np.hypot(*centre(roll))) + self.tip_radius - self.crest_radius

        crest_roll = ((self.crest_radius / self.base_radius) ** 2 - 1.0) ** 0.5
        roll = brentq(excess, 0.3 * crest_roll, crest_roll, xtol=1e-15)
        return roll, centre(roll)

    def rounding(self, angle: float) -> FloatArray:
        """Point of the rounding whose normal into the shaper has this angle from +x."""
        _, centre = self.form()
        return centre - self.tip_radius * np.array([cos(angle), sin(angle)])

    def inward(self, outline: Callable[[float], FloatArray], parameter: float) -> FloatArray:
        """Unit normal of an outline into the shaper (out of the gear), by finite differences."""
        step = 1e-4
        ahead = [outline(parameter + k * step) for k in (-2, -1, 1, 2)]
        along = (ahead[0] - 8.0 * ahead[1] + 8.0 * ahead[2] - ahead[3]) / 12.0
        normal = np.array([along[1], -along[0]]) / np.hypot(*along)
        point = outline(parameter)
        side = normal if normal @ np.array([-point[0], 0.0]) > 0.0 else -normal
        return np.array([*side, 0.0])

    def generated(
        self, outline: Callable[[float], FloatArray], parameter: float, radius: float
    ) -> tuple[FloatArray, FloatArray]:
        """Point and normal, in the gear frame, that a point of the outline generates at a gear radius."""
        section, normal = outline(parameter), self.inward(outline, parameter)
        start = atan2(normal[1], normal[0])

        def placed(tau: float) -> tuple[FloatArray, FloatArray]:
            point = about_z(tau, np.array([*section, 0.0]))
            point[2] = (radius**2 - point[0] ** 2) ** 0.5
            return point, about_z(tau, normal)

        def penetration_rate(tau: float) -> float:
            point, turned = placed(tau)
            shaper_velocity = np.cross([0.0, 0.0, 1.0], point)
            gear_velocity = np.cross([0.0, self.ratio, 0.0], point)
            return float(turned @ (shaper_velocity - gear_velocity))

        # the normal stands between the x and the y direction (the crest: on y) when the point is generated
        tau = brentq(penetration_rate, 1e-4 - start, 0.5 * pi + 1e-4 - start, xtol=1e-15)
        point, turned = placed(tau)
        return about_y(-self.ratio * tau, point), about_y(-self.ratio * tau, turned)

    def depth(self, point: FloatArray) -> float:
        """How deep a point (x, y) lies in a tooth of the shaper [mm]; negative outside."""
        form, centre = self.form()
        distance = float(np.hypot(*point))
        polar = atan2(point[0], -point[1])
        pitch = 2.0 * pi / self.teeth
        aside = abs(polar - pitch * round(polar / pitch))
        if distance <= self.base_radius * hypot(1.0, form):
            if distance < self.base_radius:
                return -1.0  # the shaper's own tooth root, of no concern
            roll = ((distance / self.base_radius) ** 2 - 1.0) ** 0.5
            return self.base_radius * (-(roll - atan(roll) + self.phase) - aside)
        if aside < abs(atan2(centre[0], -centre[1])):
            return self.crest_radius - distance
        folded = distance * np.array([-sin(aside), -cos(aside)])
        return self.tip_radius - float(np.hypot(*(folded - centre)))

    def deepest(self, point: FloatArray) -> float:
        """Greatest depth of a gear point in any tooth over all positions of the shaper [mm]."""

        def outside(tau: float) -> float:
            placed = about_z(-tau, about_y(self.ratio * tau, point))
            return -self.depth(placed[:2])

        tau = np.linspace(-0.8, 0.8, 801)
        values = np.array([outside(t) for t in tau])
        worst = values.min()
        for k in np.argsort(values)[:3]:
            step = tau[1] - tau[0]
            found = minimize_scalar(
                outside, bounds=(tau[k] - step, tau[k] + step), method="bounded", options={"xatol": 1e-12}
            )
            worst = min(worst, found.fun)
        return -float(worst)


def flank_grid(gear: FaceGearTooth) -> list[tuple[float, float]]:
    """Radii and profile coordinates all over the flank, ends included."""
    return [
        (radius, float(profile))
        for radius in FACES[gear]
        for profile in np.linspace(gear.root_profile, float(gear.tip_profile(np.array(radius))), 9)
    ]


# ---- figures of the design, section 3


def test_undercut_figures() -> None:
    """The singular point is found again as the place where the numerical envelope turns back."""
    assert GEAR.undercut_radius() == pytest.approx(465.17, abs=0.05)
    shaper = Shaper.of(GEAR)
    crest_roll = ((shaper.crest_radius / shaper.base_radius) ** 2 - 1.0) ** 0.5

    def envelope(roll: float, tau: float) -> tuple[FloatArray, FloatArray, float]:
        section, normal = shaper.involute(roll), shaper.inward(shaper.involute, roll)
        point, turned = about_z(tau, np.array([*section, 0.0])), about_z(tau, normal)

        def penetration_rate(z: float) -> float:
            placed = point + np.array([0.0, 0.0, z])
            relative = np.cross([0.0, 0.0, 1.0], placed) - np.cross([0.0, shaper.ratio, 0.0], placed)
            return float(turned @ relative)

        z = brentq(penetration_rate, 0.5 * GEAR.pitch_radius, 2.0 * GEAR.pitch_radius, xtol=1e-13)
        placed = point + np.array([0.0, 0.0, z])
        turn = -shaper.ratio * tau
        return about_y(turn, placed), about_y(turn, turned), z

    def surface_element(tau: float) -> float:
        step = 1e-4
        along_roll = envelope(crest_roll + step, tau)[0] - envelope(crest_roll - step, tau)[0]
        along_tau = envelope(crest_roll, tau + step)[0] - envelope(crest_roll, tau - step)[0]
        return float(envelope(crest_roll, tau)[1] @ np.cross(along_roll, along_tau)) / (2.0 * step) ** 2

    # normal angles of 2 to 15 degrees at generation
    lowest = -crest_roll - shaper.phase
    tau = brentq(surface_element, lowest + radians(2.0), lowest + radians(15.0), xtol=1e-12)
    point, _, z = envelope(crest_roll, tau)
    assert hypot(point[0], point[2]) == pytest.approx(GEAR.undercut_radius(), abs=1e-3)
    assert z == pytest.approx(463.00, abs=0.05)


def test_pointing_figures() -> None:
    assert GEAR.pointing_radius() == pytest.approx(569.33, abs=0.05)
    assert GEAR.half_thickness(GEAR.pointing_radius(), MODULE) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("shaper_teeth", "pointed"), [(4, False), (5, False), (6, True)])
def test_teeth_that_stay_wide_are_not_pointed(shaper_teeth: int, pointed: bool) -> None:
    """Far out the flank is generated at an angle of 90 degrees, which gives the angle between both flanks there."""
    alpha, addendum = radians(60.0), 0.05 * MODULE
    gear = replace(GEAR, shaper_teeth=shaper_teeth, pressure_angle=alpha, gear_addendum=addendum)
    roll = (1.0 - 2.0 * addendum / (MODULE * shaper_teeth)) / cos(alpha)
    far = 0.5 * pi - shaper_teeth * (0.5 * pi + tan(alpha) - alpha - roll)
    assert (far < 0.0) == pointed
    found = gear.pointing_radius()
    assert found > 4.0 * gear.pitch_radius
    assert np.isfinite(found) == pointed
    if pointed:
        assert gear.half_thickness(found, addendum) == pytest.approx(0.0, abs=1e-9)


def test_half_thickness_figures() -> None:
    assert GEAR.half_thickness(508.0, 0.0) == pytest.approx(0.25 * pi * MODULE, abs=1e-9)
    assert GEAR.half_thickness(508.0, MODULE) == pytest.approx(2.028, abs=5e-4)
    assert GEAR.half_thickness(560.0, MODULE) == pytest.approx(0.374, abs=5e-4)


def test_crest_is_fully_round() -> None:
    radius = brentq(lambda r: replace(GEAR, shaper_tip_radius=r).crest_half_width, 1.0, 1.5)
    assert radius == pytest.approx(1.311, abs=5e-4)
    _, centre = replace(Shaper.of(GEAR), tip_radius=radius).form()
    assert centre[0] == pytest.approx(0.0, abs=1e-9)


# ---- the gear's flank and fillet against the swept shaper


@GEARS
def test_flank_is_the_numerical_envelope(gear: FaceGearTooth) -> None:
    shaper = Shaper.of(gear)
    for radius, profile in flank_grid(gear):
        roll = float(gear.roll_from_profile(np.array(profile)))
        expected, expected_normal = shaper.generated(shaper.involute, roll, radius)
        point, normal = gear.points(np.array(radius), np.array(profile))
        np.testing.assert_allclose(point, expected, rtol=0.0, atol=1e-6)
        np.testing.assert_allclose(normal, expected_normal, rtol=0.0, atol=1e-6)


@GEARS
def test_fillet_is_the_numerical_envelope(gear: FaceGearTooth) -> None:
    shaper = Shaper.of(gear)
    form, centre = shaper.form()
    assert form == pytest.approx(gear.form_roll_angle, abs=1e-12)
    angles = np.linspace(form + shaper.phase, atan2(-centre[1], -centre[0]), 13)
    for radius in FACES[gear]:
        fillet = gear.fillet(radius, points=13)
        for angle, point in zip(angles, fillet, strict=True):
            expected, _ = shaper.generated(shaper.rounding, float(angle), radius)
            np.testing.assert_allclose(point, expected, rtol=0.0, atol=1e-6)


@pytest.mark.slow
@GEARS
def test_the_shaper_touches_every_point_and_penetrates_none(gear: FaceGearTooth) -> None:
    shaper = Shaper.of(gear)
    points = [gear.points(np.array(r), np.array(p))[0] for r, p in flank_grid(gear)[::2]]
    for radius in FACES[gear][::2]:
        points += list(gear.fillet(radius, points=5))
    for point in points:
        assert shaper.deepest(point) == pytest.approx(0.0, abs=1e-6)
    # the test can tell: a point a hair inside the space is cut off, one inside the tooth is never reached
    point, normal = gear.points(np.array(FACES[gear][1]), np.array(0.0))
    assert shaper.deepest(point + 1e-3 * normal) == pytest.approx(1e-3, rel=1e-2)
    assert shaper.deepest(point - 1e-3 * normal) == pytest.approx(-1e-3, rel=1e-2)


@GEARS
def test_fillet_continues_the_flank_smoothly(gear: FaceGearTooth) -> None:
    for radius in FACES[gear]:
        end, normal = gear.points(np.array(radius), np.array(gear.root_profile))
        fillet = gear.fillet(radius, points=20001)
        np.testing.assert_allclose(fillet[0], end, rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(np.hypot(fillet[:, 0], fillet[:, 2]), radius, rtol=1e-12)
        along = -1.5 * fillet[0] + 2.0 * fillet[1] - 0.5 * fillet[2]
        assert along @ normal / np.linalg.norm(along) == pytest.approx(0.0, abs=1e-6)
        # and runs out into the root plane
        assert fillet[-1, 1] == pytest.approx(-gear.shaper_crest_radius, abs=1e-9)
        last = 1.5 * fillet[-1] - 2.0 * fillet[-2] + 0.5 * fillet[-3]
        assert last[1] / np.linalg.norm(last) == pytest.approx(0.0, abs=1e-6)
        assert np.all(np.diff(fillet[:, 1]) < 0.0)


# ---- the pinion


@PINIONS
def test_involute_identities(pinion: InvoluteTooth) -> None:
    base = pinion.base_radius
    for roll in np.linspace(pinion.form_roll_angle, pinion.tip_roll_angle, 7):
        distance = base * hypot(1.0, roll)
        # the string is as long as the arc that it covered, and touches the base circle
        assert distance**2 - base**2 == pytest.approx((base * roll) ** 2, rel=1e-12)
        pressure_angle = acos(base / distance)
        involute = tan(pressure_angle) - pressure_angle
        thickness = 2.0 * distance * -float(pinion.polar_angle(np.array(roll)))
        alpha = pinion.pressure_angle
        expected = 2.0 * distance * (0.5 * pi / pinion.teeth + tan(alpha) - alpha - involute)  # ISO 21771
        assert thickness == pytest.approx(expected, rel=1e-12)


@PINIONS
def test_profile_coordinate_is_arc_length(pinion: InvoluteTooth) -> None:
    def speed(roll: float) -> float:
        step = 1e-5

        def place(at: float) -> FloatArray:
            distance, polar = pinion.base_radius * hypot(1.0, at), float(pinion.polar_angle(np.array(at)))
            return distance * np.array([sin(polar), -cos(polar)])

        return float(np.hypot(*(place(roll + step) - place(roll - step)))) / (2.0 * step)

    start, end = pinion.form_roll_angle, pinion.tip_roll_angle
    length, _ = quad(speed, start, end, epsabs=1e-9)
    ends = pinion.profile_from_roll(np.array([start, end]))
    assert length == pytest.approx(ends[1] - ends[0], abs=1e-6)
    assert float(pinion.profile_from_roll(tan(pinion.pressure_angle))) == pytest.approx(0.0, abs=1e-12)


@PINIONS
def test_tip_thickness_and_base_pitch(pinion: InvoluteTooth) -> None:
    tip_angle = acos(pinion.base_radius / pinion.tip_radius)
    alpha = pinion.pressure_angle
    half = 0.5 * pi / pinion.teeth + tan(alpha) - alpha - tan(tip_angle) + tip_angle
    assert pinion.tip_half_thickness == pytest.approx(pinion.tip_radius * half, rel=1e-12)
    assert pinion.base_pitch == pytest.approx(pi * pinion.module * cos(alpha), rel=1e-12)


class Rack:
    """The rack tooth that cuts the space beside the tooth on +y, in the pinion's frame; it rolls by `rolled`."""

    def __init__(self, pinion: InvoluteTooth):
        self.pinion = pinion
        alpha, radius = pinion.pressure_angle, pinion.rack_tip_radius
        self.depth = pinion.rack_addendum - radius

        def to_flank(offset: float) -> float:
            """Distance from the rounding's centre to the flank, a line through (pi m/4, 0)."""
            return (0.25 * pi * pinion.module - offset) * cos(alpha) - self.depth * sin(alpha) - radius

        self.offset = brentq(to_flank, -pinion.module, pinion.module, xtol=1e-15)

    def in_rack(self, point: FloatArray, rolled: float) -> tuple[float, float]:
        """Depth below the pitch line and distance from the rack tooth's middle of a pinion point."""
        pinion = self.pinion
        # the middle of the space stands on +y when nothing has rolled
        angle = atan2(point[0], point[1]) - pi / pinion.teeth + rolled / pinion.pitch_radius
        distance = float(np.hypot(*point))
        return pinion.pitch_radius - distance * cos(angle), distance * sin(angle) - rolled

    def depth_inside(self, point: FloatArray, rolled: float) -> float:
        """How deep a pinion point lies in the rack tooth [mm]; negative outside."""
        pinion, alpha = self.pinion, self.pinion.pressure_angle
        down, aside = self.in_rack(point, rolled)
        aside = abs(aside)
        to_line = (0.25 * pi * pinion.module - aside) * cos(alpha) - down * sin(alpha)
        if aside < self.offset:
            return min(pinion.rack_addendum - down, to_line)
        # beyond the point where the rounding touches the flank, seen along the flank
        along = (down - self.depth) * cos(alpha) - (aside - self.offset) * sin(alpha)
        if along > 0.0:
            return pinion.rack_tip_radius - hypot(down - self.depth, aside - self.offset)
        return to_line

    def deepest(self, point: FloatArray) -> float:
        """Greatest depth of a point in the rack over all its positions [mm]."""
        rolled = np.linspace(-4.0, 4.0, 801) * self.pinion.module
        values = np.array([-self.depth_inside(point, u) for u in rolled])
        k = int(np.argmin(values))
        step = rolled[1] - rolled[0]
        found = minimize_scalar(
            lambda u: -self.depth_inside(point, u),
            bounds=(rolled[k] - step, rolled[k] + step),
            method="bounded",
            options={"xatol": 1e-11},
        )
        return -float(min(found.fun, values[k]))


@PINIONS
def test_the_rack_touches_every_point_and_penetrates_none(pinion: InvoluteTooth) -> None:
    rack, section = Rack(pinion), pinion.section(flank_points=15)
    for point in [*section.flank, *pinion.fillet(points=21)]:
        assert rack.deepest(point) == pytest.approx(0.0, abs=1e-6)
    out = np.array([1e-3, 0.0])
    assert rack.deepest(section.flank[7] + out) > 5e-4


@PINIONS
def test_fillet_is_touched_by_the_rack_tip_circle(pinion: InvoluteTooth) -> None:
    rack = Rack(pinion)
    for point in pinion.fillet(points=21):

        def distance(rolled: float, point: FloatArray = point) -> float:
            down, aside = rack.in_rack(point, rolled)
            return hypot(down - rack.depth, aside + rack.offset)

        nearest = minimize_scalar(
            distance, bounds=(-3.0 * pinion.module, pinion.module), method="bounded", options={"xatol": 1e-11}
        )
        assert nearest.fun == pytest.approx(pinion.rack_tip_radius, abs=1e-6)


@PINIONS
def test_pinion_fillet_continues_the_flank_smoothly(pinion: InvoluteTooth) -> None:
    fillet = pinion.fillet(points=20001)
    roll = pinion.form_roll_angle
    polar = -float(pinion.polar_angle(np.array(roll)))
    end = pinion.base_radius * hypot(1.0, roll) * np.array([sin(polar), cos(polar)])
    np.testing.assert_allclose(fillet[0], end, rtol=0.0, atol=1e-9)
    # the flank's normal, which touches the base circle
    normal_angle = polar - atan(roll)
    normal = np.array([cos(normal_angle), -sin(normal_angle)])
    along = -1.5 * fillet[0] + 2.0 * fillet[1] - 0.5 * fillet[2]
    assert along @ normal / np.hypot(*along) == pytest.approx(0.0, abs=1e-6)
    # and runs out into the root circle
    assert np.hypot(*fillet[-1]) == pytest.approx(pinion.root_radius, abs=1e-9)
    last = 1.5 * fillet[-1] - 2.0 * fillet[-2] + 0.5 * fillet[-3]
    assert last @ fillet[-1] / np.hypot(*last) / pinion.root_radius == pytest.approx(0.0, abs=1e-6)
