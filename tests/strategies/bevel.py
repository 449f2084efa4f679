"""Spiral bevel and hypoid flanks from a construction of their own: nothing here comes from semiwear.

The gear is cut without generation (Formate): its convex flank is the cone of a face-mill cutter whose axis stands
across the pitch cone. The pinion's flank is the envelope of the gear's in their relative motion: each gear point
touches it when its normal stands across the relative velocity. An ease-off, taken off the pinion along the normal,
makes the contact a point (Litvin and Fuentes 2004, Gear Geometry and Applied Theory, ch. 6 and 21; Stadtfeld 1993,
Handbook of Bevel and Hypoid Gears).

Fixed frame: z is the pinion's axis, the gear's axis runs along -y, `offset` along x aside. The gear's pitch cone
has its apex on that axis. Without offset it lies at the origin, and the mean point in the plane x = 0. With an
offset the mean point stands where the pinion's velocity lies in the pitch plane as well, and the apex where the
relative velocity runs along the tooth there: the pitch cones touch (Litvin and Fuentes 2004, section 21.4).
"""

from dataclasses import dataclass, field
from functools import cached_property
from math import asin, atan2, cos, radians, sin, tan

import numpy as np
from scipy.optimize import brentq

from semiwear.arrays import FloatArray

_NEAR = 15  # columns to either side, to which the least gap is fitted


def rotated(vectors: FloatArray, axis: FloatArray, angle: FloatArray) -> FloatArray:
    """Vectors turned about a unit axis through the origin (Rodrigues)."""
    c, s = np.cos(angle)[..., None], np.sin(angle)[..., None]
    along = np.sum(vectors * axis, axis=-1, keepdims=True) * axis
    return along + c * (vectors - along) + s * np.cross(axis, vectors)


@dataclass(frozen=True)
class BevelPair:
    """A Formate gear and the pinion that it envelopes, eased off; lengths in mm.

    Attributes
    ----------
    crowning, profile_crowning : float
        Taken off the pinion at both ends of the face, and at its root and tip.
    """

    pinion_teeth: int = 15
    gear_teeth: int = 41
    offset: float = 0.0
    mean_cone_distance: float = 85.0
    face_width: float = 26.0
    spiral_angle: float = radians(35.0)
    pressure_angle: float = radians(20.0)
    cutter_radius: float = 76.2
    gear_addendum: float = 1.5
    pinion_addendum: float = 2.8
    crowning: float = 0.02
    profile_crowning: float = 0.006
    pinion_axis: FloatArray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    gear_axis: FloatArray = field(default_factory=lambda: np.array([0.0, -1.0, 0.0]))

    @property
    def ratio(self) -> float:
        return self.pinion_teeth / self.gear_teeth

    @property
    def pitch_angle(self) -> float:
        """Of the gear."""
        return atan2(self.gear_teeth, self.pinion_teeth)

    @cached_property
    def _mounting(self) -> tuple[float, float]:
        """Angle of the mean point about the gear's axis, and how far the apex lies along that axis."""
        big, distance = self.pitch_angle, self.mean_cone_distance

        def angle(along: float) -> float:
            return asin(-self.offset * sin(big) / (distance + along * cos(big)))

        def normal_sliding(along: float) -> float:
            points, normals = self._cut(np.zeros(1), np.zeros(1))
            turn, centre = np.array([angle(along)]), np.array([self.offset, -along, 0.0])
            place, normal = rotated(points, -self.gear_axis, turn), rotated(normals, -self.gear_axis, turn)
            relative = np.cross(self.pinion_axis, place + centre) - self.ratio * np.cross(-self.gear_axis, place)
            return float(np.sum(normal * relative))

        if self.offset == 0.0:
            return 0.0, 0.0
        along = float(brentq(normal_sliding, -0.3 * distance, 0.3 * distance))
        return angle(along), along

    @property
    def gear_centre(self) -> FloatArray:
        """Apex of the gear's pitch cone."""
        return np.array([self.offset, -self._mounting[1], 0.0])

    # the gear turns about -gear_axis while the pinion turns about its axis

    @cached_property
    def _cutter(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Cutter centre and its axes, relative to the gear's centre: to the mean point, along the tooth, its axis."""
        big = self.pitch_angle
        generator, up = np.array([0.0, -cos(big), sin(big)]), np.array([0.0, sin(big), cos(big)])
        around = np.array([1.0, 0.0, 0.0])
        aside = -sin(self.spiral_angle) * generator + cos(self.spiral_angle) * around
        along = cos(self.spiral_angle) * generator + sin(self.spiral_angle) * around
        return self.mean_cone_distance * generator + self.cutter_radius * aside, -aside, along, up

    def _cut(self, angle: FloatArray, height: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Points and normals out of the gear's material of the cutter's cone, relative to the gear's centre."""
        centre, outwards, along, up = self._cutter
        radial = np.cos(angle)[..., None] * outwards + np.sin(angle)[..., None] * along
        radius = self.cutter_radius - height * tan(self.pressure_angle)
        points = centre + radius[..., None] * radial + height[..., None] * up
        return points, cos(self.pressure_angle) * radial + sin(self.pressure_angle) * up

    def gear_flank(self, rows: FloatArray, columns: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Gear points relative to its centre, and normals, at heights above the pitch cone and cone distances."""
        big = self.pitch_angle
        distance, wanted = np.meshgrid(columns, rows)
        target = np.stack([distance * sin(big) + wanted * cos(big), distance * cos(big) - wanted * sin(big)], axis=-1)

        def place(angle: FloatArray, height: FloatArray) -> FloatArray:
            points, _ = self._cut(angle, height)
            return np.stack([np.hypot(points[..., 0], points[..., 2]), -points[..., 1]], axis=-1)

        angle = (distance - self.mean_cone_distance) / self.cutter_radius / cos(self.spiral_angle)
        height, step = wanted.copy(), 1e-6
        for _ in range(8):
            here = place(angle, height)
            by_angle = (place(angle + step, height) - place(angle - step, height)) / (2.0 * step)
            by_height = (place(angle, height + step) - place(angle, height - step)) / (2.0 * step)
            move = np.linalg.solve(np.stack([by_angle, by_height], axis=-1), (target - here)[..., None])[..., 0]
            angle, height = angle + move[..., 0], height + move[..., 1]
        return self._cut(angle, height)

    def meeting(self, points: FloatArray, normals: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Gear rotation at which each gear point touches the envelope, and place and normal then, in the fixed frame.

        The rotation counts along the gear's motion.
        """
        turning = -self.gear_axis
        w_pinion, w_gear = self.pinion_axis, self.ratio * turning

        def across(angle: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
            place, normal = rotated(points, turning, angle), rotated(normals, turning, angle)
            relative = np.cross(w_pinion, place + self.gear_centre) - np.cross(w_gear, place)
            return np.sum(normal * relative, axis=-1), place + self.gear_centre, normal

        angle, step = np.full(points.shape[:-1], self._mounting[0]), 1e-6
        for _ in range(12):
            value = across(angle)[0]
            slope = (across(angle + step)[0] - across(angle - step)[0]) / (2.0 * step)
            angle = angle - np.clip(value / slope, -0.1, 0.1)
        value, place, normal = across(angle)
        assert np.abs(value).max() < 1e-9
        return angle, place, normal

    def ease_off(self, rows: FloatArray, columns: FloatArray) -> FloatArray:
        """Taken off the pinion where it touches the gear at these heights and cone distances."""
        lengthwise = (columns - self.mean_cone_distance) / (0.5 * self.face_width)
        middle = 0.5 * (self.gear_addendum - self.pinion_addendum)
        profilewise = (rows - middle) / (0.5 * (self.gear_addendum + self.pinion_addendum))
        return self.crowning * lengthwise**2 + self.profile_crowning * profilewise[:, None] ** 2

    def columns(self, count: int) -> FloatArray:
        half = 0.5 * self.face_width
        return np.linspace(self.mean_cone_distance - half, self.mean_cone_distance + half, count)

    def gear_grid(self, count: tuple[int, int] = (41, 61)) -> tuple[FloatArray, FloatArray]:
        """Gear points and normals in its own frame (z along its axis), rows from root to tip."""
        points, normals = self.gear_flank(
            np.linspace(-self.pinion_addendum - 0.05, self.gear_addendum, count[0]), self.columns(count[1])
        )
        return in_frame(points, self.gear_axis), in_frame(normals, self.gear_axis)

    def pinion_grid(self, count: tuple[int, int] = (41, 61)) -> tuple[FloatArray, FloatArray]:
        """Pinion points and normals in its own frame, rows from root to tip."""
        rows, columns = (
            np.linspace(self.gear_addendum + 0.05, -self.pinion_addendum, count[0]),
            self.columns(count[1]),
        )
        angle, place, normal = self.meeting(*self.gear_flank(rows, columns))
        back = -angle / self.ratio
        points = rotated(place + self.ease_off(rows, columns)[..., None] * normal, self.pinion_axis, back)
        return in_frame(points, self.pinion_axis), in_frame(
            -rotated(normal, self.pinion_axis, back), self.pinion_axis
        )

    # ---- tooth contact of its own, to the first order of ease-off and displacement

    @cached_property
    def _fine(self) -> tuple[FloatArray, FloatArray, tuple[FloatArray, FloatArray, FloatArray]]:
        rows, columns = np.linspace(-self.pinion_addendum, self.gear_addendum, 151), self.columns(301)
        return rows, columns, self.meeting(*self.gear_flank(rows, columns))

    def contact_shift(self, displacement: FloatArray, turn: FloatArray, pivot: FloatArray) -> float:
        """By how much a displaced pinion moves the mean contact along the face: gear cone distance.

        Parameters
        ----------
        displacement, turn : (3,) arrays [mm], [rad]
            Of the pinion, in the fixed frame; the turn is about the pivot.

        Notes
        -----
        At one rotation the gear can touch along a line. Its gap there is what was eased off plus what the
        displacement opens, n . d, and where the gap over lever arm is least the flanks touch. The line is that of
        the undisplaced contact.
        """
        rows, columns, (angle, place, normal) = self._fine
        moved = displacement + np.cross(turn, place - pivot)
        lever = np.sum(np.cross(self.pinion_axis, place) * -normal, axis=-1)
        middle = angle[rows.size // 2, columns.size // 2]
        falls = np.all(np.diff(angle, axis=0) < 0.0)
        across, order = (angle[::-1], slice(None, None, -1)) if falls else (angle, slice(None))
        on_line = (across[0] <= middle) & (middle <= across[-1])
        shifts = []
        for change in (0.0, 1.0):
            gap = ((self.ease_off(rows, columns) + change * np.sum(normal * moved, axis=-1)) / lever)[order]
            at = np.full(columns.size, np.inf)
            for k in np.flatnonzero(on_line):
                at[k] = np.interp(middle, across[:, k], gap[:, k])
            near = np.abs(np.arange(columns.size) - np.argmin(at)) <= _NEAR
            bend, slope, _ = np.polyfit(columns[near & on_line], at[near & on_line], 2)
            shifts.append(-0.5 * float(slope / bend))
        return shifts[1] - shifts[0]


def in_frame(vectors: FloatArray, axis: FloatArray) -> FloatArray:
    """Vectors in a right-handed frame whose third axis is the given one."""
    aside = np.eye(3)[int(np.argmin(np.abs(axis)))]
    x = np.cross(aside, axis)
    x /= np.linalg.norm(x)
    return vectors @ np.column_stack([x, np.cross(axis, x), axis])
