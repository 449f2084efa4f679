"""Tooth sections of a flank given as points whose file has none: half a tooth with fillet and rim.

Each section is normal to the tooth where the flank crosses the pitch surface, in the middle half of its height. The
other flank is its mirror image, at a tooth thickness from it. A body whose pitch surface is round becomes the
virtual spur gear of Tredgold, with as many teeth as the radius of curvature of the pitch surface across the teeth
gives (Litvin and Fuentes 2004, ch. 21; ISO 10300-1, virtual cylindrical gears); one that is flat, hollow or has
very many teeth becomes a rack. The fillet is an arc that continues the flank's lower end, or a straight
piece below it, and ends on the root.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
from scipy.optimize import brentq

from semiwear.arrays import FloatArray
from semiwear.errors import Problem, SceneError
from semiwear.geometry.point_grid import PlacedSection
from semiwear.geometry.section import RackRim, RingRim, ToothSection
from semiwear.meshing.flank_pair import BODIES, PrismBody
from semiwear.meshing.point_flank_body import FlankBody
from semiwear.meshing.point_pitch import PitchSurface
from semiwear.scene import FlankPointsPair

_STATIONS = np.linspace(0.0, 1.0, 5)
_ALIKE = 1e-3  # of the flank's height: sections that differ by less count as equal
_FLANK_POINTS, _FILLET_POINTS, _STRAIGHT_POINTS = 61, 41, 9
_MOST_RING_TEETH, _LEAST_RING_TEETH = 300, 6
_FILLET, _RIM = 0.3, 2.5  # normal modules
_MIDDLE = (0.25, 0.75)  # of the flank: range in which its thickness is given
_ROOM = 0.999  # of half a pitch: farthest end of a fillet


class _Unfit(Exception):
    """A field that leaves no room for a section."""

    def __init__(self, name: str, value: object, allowed: str, fix: str) -> None:
        super().__init__(name)
        self.name, self.value, self.allowed, self.fix = name, value, allowed, fix


def placed_sections(
    own: FlankBody, placed: tuple[PlacedSection, ...], mean: bool, tooth_length: float | None = None
) -> PrismBody:
    """Sections of a file.

    Parameters
    ----------
    own : FlankBody
    placed : tuple of PlacedSection
        Sections whose `flank_profile` holds rows of the grid.
    mean : bool
        Whether the profile coordinate is scaled with the mean length of the flank.
    tooth_length : float [mm], optional
        Default: the length in the middle of the flank.
    """
    u = own.surface.u
    rows = np.arange(u.size)
    found = []
    for entry in placed:
        at = entry.section.flank_profile
        fraction = np.interp(at, rows, u)
        fraction += np.minimum(at, 0.0) * (u[1] - u[0]) + np.maximum(at - rows[-1], 0.0) * (u[-1] - u[-2])
        length = own.mean_length if mean else float(own.profile_length(own.v_at(np.array(entry.face))))
        section = entry.section
        found.append(
            (entry.face, ToothSection(section.flank, own.profile_at(fraction, length), section.fillet, section.rim))
        )
    return _body(own, found, tooth_length)


def drawn_sections(table: FlankPointsPair, body: int, own: FlankBody, pitch: PitchSurface, mean: bool) -> PrismBody:
    """Sections drawn from the points and the scene's fields.

    Raises
    ------
    SceneError
        Where a field leaves no room for the fillet or the tooth.
    """
    try:
        planes = [_Plane.of(own, pitch, float(v)) for v in _STATIONS]
        # one kind of rim for the whole body
        ring = all(_LEAST_RING_TEETH <= plane.virtual_teeth <= _MOST_RING_TEETH for plane in planes)
        sections = [
            _section(table, BODIES[body], own, plane, float(v), ring, mean)
            for plane, v in zip(planes, _STATIONS, strict=True)
        ]
    except _Unfit as unfit:
        raise SceneError.of(f"gear_pair.{unfit.name}", unfit.value, unfit.allowed, unfit.fix) from None
    middle = sections[len(sections) // 2]
    apart = max(float(np.abs(np.vstack([s.flank - middle.flank, s.fillet - middle.fillet])).max()) for s in sections)
    if apart < _ALIKE * own.mean_length and all(section.rim == middle.rim for section in sections):
        return _body(own, [(float(own.face_at(np.array(0.5))), middle)])
    return _body(own, [(float(own.face_at(v)), section) for v, section in zip(_STATIONS, sections, strict=True)])


def normal_module(own: FlankBody, pitch: PitchSurface) -> float:
    """Normal module of a body in the middle of its teeth, where its flank crosses the pitch surface [mm]."""
    return _Plane.of(own, pitch, 0.5).pitch / pi


def section_problems(table: FlankPointsPair, body: int, own: FlankBody, pitch: PitchSurface) -> list[Problem]:
    """Problems of the fields that determine the drawn sections."""
    try:
        drawn_sections(table, body, own, pitch, False)
    except SceneError as error:
        return list(error.problems)
    return []


def _body(own: FlankBody, sections: list[tuple[float, ToothSection]], length: float | None = None) -> PrismBody:
    low, high = own.face_limits
    ordered = sorted(sections, key=lambda entry: entry[0])
    faces = tuple(face for face, _ in ordered)
    return PrismBody(high - low, low, faces, tuple(entry for _, entry in ordered), length or own.surface.face_length)


@dataclass(frozen=True)
class _Plane:
    """The flank in the section plane: from its pitch point outwards (x) and towards the tip (y), tip first."""

    flank: FloatArray
    pitch: float  # between neighbouring teeth
    curvature: float  # of the pitch surface across the teeth

    @property
    def virtual_teeth(self) -> int:
        """Teeth of the virtual spur gear; 0 where the pitch surface is flat or hollow."""
        return round(2.0 * pi / (self.curvature * self.pitch)) if self.curvature > 0.0 else 0

    @classmethod
    def of(cls, own: FlankBody, surface: PitchSurface, v: float) -> _Plane:
        grid = np.linspace(0.0, 1.0, 201)
        heights = surface.height(*own.radius_and_axial(grid, np.full(grid.size, v)))
        # where the pitch surface leaves the flank, or nearly so, the middle part is used
        crossing = float(np.clip(grid[np.argmin(np.abs(heights))], *_MIDDLE))
        at = own.evaluate(np.array([crossing]), np.array([v]))
        point, across, along = (entry[0] for entry in at)
        normal = own.points(np.array([crossing]), np.array([v]))[1][0]
        along = along / np.linalg.norm(along)
        radius = float(np.hypot(point[0], point[1]))
        around = np.array([-point[1], point[0], 0.0]) / radius
        around *= np.sign(around @ normal)
        outwards = around - (around @ along) * along
        fraction = float(np.linalg.norm(outwards))  # of the transverse pitch, in the normal section
        outwards /= fraction
        upwards = np.cross(along, outwards)
        upwards *= np.sign(upwards @ across)
        line = own.evaluate(np.linspace(1.0, 0.0, _FLANK_POINTS), np.full(_FLANK_POINTS, v))[0] - point
        radial = (upwards[0] * point[0] + upwards[1] * point[1]) / radius
        return cls(
            np.column_stack([line @ outwards, line @ upwards]),
            2.0 * pi * radius / own.teeth * fraction,
            radial * fraction**2 / radius,
        )


def _section(
    table: FlankPointsPair, body: str, own: FlankBody, plane: _Plane, v: float, ring: bool, mean: bool
) -> ToothSection:
    module = plane.pitch / pi

    def chosen(name: str, default: float) -> float:
        value = getattr(table, f"{body}_{name}")
        return default if value == "auto" else float(value)

    thickness = chosen("tooth_thickness_mm", 0.5 * plane.pitch)
    if thickness >= 0.9 * plane.pitch:
        allowed = f"less than the pitch in the normal section ({plane.pitch:.4g} mm)"
        raise _Unfit(f"{body}_tooth_thickness_mm", thickness, allowed, 'usually about half of it: give "auto"')
    teeth = plane.virtual_teeth
    x, y = plane.flank.T
    if ring:
        radius = teeth * plane.pitch / (2.0 * pi)
        half = 0.5 * thickness / radius
        flank = np.column_stack(
            [(radius + y) * np.sin(half) + x * np.cos(half), (radius + y) * np.cos(half) - x * np.sin(half)]
        )
    else:
        flank = np.column_stack([0.5 * thickness + x, y])
    if np.any(flank[:, 0] <= 0.0):
        fix = "the tooth would be pointed below its tip: give more, or fewer rows of points"
        raise _Unfit(f"{body}_tooth_thickness_mm", thickness, "a tooth with a land at its tip", fix)
    fillet = _fillet(
        table, body, flank, teeth if ring else 0, plane.pitch, chosen("fillet_radius_mm", _FILLET * module)
    )
    rim = chosen("rim_thickness_mm", _RIM * module)
    fraction = np.linspace(1.0, 0.0, _FLANK_POINTS)
    length = own.mean_length if mean else float(own.profile_length(np.array(v)))
    if not ring:
        return ToothSection(
            flank, own.profile_at(fraction, length), fillet, RackRim(plane.pitch, float(fillet[-1, 1]) - rim)
        )
    root = float(np.hypot(*fillet[-1]))
    if rim >= root:
        if getattr(table, f"{body}_rim_thickness_mm") != "auto":
            allowed = f"less than the virtual gear's root radius ({root:.4g} mm)"
            raise _Unfit(f"{body}_rim_thickness_mm", rim, allowed, "the body is a ring on a bore: give less")
        rim = 0.5 * root
    return ToothSection(flank, own.profile_at(fraction, length), fillet, RingRim(teeth, root - rim))


def _fillet(  # noqa: C901
    table: FlankPointsPair, body: str, flank: FloatArray, teeth: int, pitch: float, radius: float
) -> FloatArray:
    """Arc from the end of the flank to the root; `teeth` is 0 for a rack."""
    end, down = flank[-1], flank[-1] - flank[-2]
    down = down / np.linalg.norm(down)
    outwards = np.array([-down[1], down[0]])  # into the tooth space

    def bottom(centre: FloatArray) -> FloatArray:
        return -centre / np.linalg.norm(centre) if teeth else np.array([0.0, -1.0])

    def height(point: FloatArray) -> float:
        return float(np.linalg.norm(point)) if teeth else float(point[1])

    def reach(size: float, below: float) -> float:
        """End of the arc over half a pitch."""
        centre = end + below * down + size * outwards
        last = centre + size * bottom(centre)
        return float(np.arctan2(last[0], last[1])) * teeth / pi if teeth else 2.0 * float(last[0]) / pitch

    def depth(below: float) -> float:
        centre = end + below * down + radius * outwards
        return height(end) - (height(centre) - radius)

    root_depth = getattr(table, f"{body}_root_depth_mm")
    given = getattr(table, f"{body}_fillet_radius_mm")
    if reach(0.0, 0.0) >= _ROOM:
        fix = "give less: the flanks of neighbouring teeth meet above the root"
        raise _Unfit(f"{body}_tooth_thickness_mm", getattr(table, f"{body}_tooth_thickness_mm"), "a tooth space", fix)
    if reach(radius, 0.0) > _ROOM:
        greatest = float(brentq(lambda size: reach(size, 0.0) - _ROOM, 0.0, radius))
        if given != "auto":
            fix = 'the tooth space would be more than round: give less, or "auto"'
            raise _Unfit(f"{body}_fillet_radius_mm", given, f"up to {greatest:.4g} mm", fix)
        radius = greatest
    below = 0.0
    if root_depth != "auto":
        if depth(0.0) > root_depth:
            if given != "auto" or root_depth <= 0.0:
                fix = "the fillet alone goes deeper: give more, or a smaller fillet radius"
                raise _Unfit(f"{body}_root_depth_mm", root_depth, f"at least {depth(0.0):.4g} mm", fix)
            radius *= root_depth / depth(0.0)
        below = float(brentq(lambda length: depth(length) - root_depth, -1e-9 * pitch, 4.0 * root_depth))
        if reach(radius, below) > _ROOM:
            lowest = float(brentq(lambda length: reach(radius, length) - _ROOM, 0.0, below))
            fix = 'the tooth space closes above: give less, a smaller fillet radius, or "auto"'
            raise _Unfit(f"{body}_root_depth_mm", root_depth, f"up to {depth(lowest):.4g} mm", fix)
    start = end + max(below, 0.0) * down
    centre = start + radius * outwards
    to = bottom(centre)
    first, last = np.arctan2(-outwards[1], -outwards[0]), np.arctan2(to[1], to[0])
    sweep = np.mod(last - first, 2.0 * pi)
    straight_piece = below > 1e-9 * pitch
    # as many points with a straight piece as without
    count = _FILLET_POINTS if straight_piece else _FILLET_POINTS + _STRAIGHT_POINTS - 1
    angle = first + sweep * np.linspace(0.0, 1.0, count)
    arc = centre + radius * np.column_stack([np.cos(angle), np.sin(angle)])
    if straight_piece:
        straight = end + np.linspace(0.0, 1.0, _STRAIGHT_POINTS)[:-1, None] * (start - end)
        return np.vstack([straight, arc])
    arc[0] = end
    return np.asarray(arc)
