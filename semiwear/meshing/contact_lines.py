"""Fresh contact lines: the valley of the separation, slice by slice, for every roll position.

A slice is a curve of constant `face` on the driven flank. In each slice the separation has one minimum along
the profile; the minima of all slices are the contact line (the valley), or its continuation along a border of
either flank. Around its minimum each slice keeps a quartic in the profile coordinate, so that a worn flank can
be searched without evaluating the geometry again.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from semiwear.arrays import BoolArray, FloatArray
from semiwear.geometry.face_slices import slice_middles
from semiwear.meshing.flank_pair import FlankPair
from semiwear.meshing.least_separation import least_places, with_far_terms

_SAMPLES = 25  # across a slice, to bracket the minimum of the convex separation
_SHARP = 5e-8  # of the base pitch: a nanometre at a module of some mm
_STEP = 0.02  # of the flank's height, for the five-point differences


@dataclass(frozen=True, eq=False)
class ContactLines:
    """Contact lines of one tooth pair; arrays are (roll, face) unless said otherwise.

    Attributes
    ----------
    roll : (K,) array
        Roll positions, rising.
    face : (S,) array [mm]
        Face stations: the middles of equal slices.
    profile : array [mm]
        Profile coordinate of the line, held inside [low, high].
    low, high : array [mm]
        Ends of the part of the slice that can touch: the driven flank's own ends or the driving body's tip.
    separation : (5, roll, face) array
        Value and first four derivatives of the separation by the profile coordinate, at `profile` (near a base circle
        the last two are those of a quartic that meets the separation farther out);
        the rounding of the end edges is part of the value, which is infinite where a slice lies wholly beyond an
        end or the tip of the driving flank.
    spacing : array
        Distance normal to the line per profile coordinate [mm/mm].
    length : array [mm]
        Length of the line in the slice, taken as straight with the direction in the middle of the slice. Line
        loads are forces over it.
    arc : array [mm]
        Arc length along the line, from the first slice.
    sliding : (roll, face, 2) array [mm per unit time]
        Sliding velocity (driving minus driven) normal to the line, towards the tip, and along it.
    sliding_slope : (roll, face, 2) array
        Its derivative by the profile coordinate.
    lever_arm : array [mm]
        Approach per unit rotation of the driving body.
    driving_profile : array [mm]
        Profile coordinate of the mating point on the driving flank.
    driving_slope : array
        Its derivative by the profile coordinate of the driven flank.
    driving_face : array [mm]
        Face coordinate of the mating point on the driving flank.
    low_edge_radius, high_edge_radius : array [mm]
        Radius of the edge at either end; zero where the end is no edge (the start of a fillet).
    """

    roll: FloatArray
    face: FloatArray
    profile: FloatArray
    low: FloatArray
    high: FloatArray
    separation: FloatArray
    spacing: FloatArray
    length: FloatArray
    arc: FloatArray
    sliding: FloatArray
    sliding_slope: FloatArray
    lever_arm: FloatArray
    driving_profile: FloatArray
    driving_slope: FloatArray
    driving_face: FloatArray
    low_edge_radius: FloatArray
    high_edge_radius: FloatArray

    @property
    def curvature(self) -> FloatArray:
        """Curvature of the fresh separation across the line, (roll, face) [1/mm]."""
        return np.asarray(self.separation[2] / self.spacing**2)

    def on_driving(self, profile: FloatArray) -> FloatArray:
        """Profile coordinate of the driving flank that mates with one of the driven flank [mm], (roll, face) both."""
        return self.driving_profile + self.driving_slope * (profile - self.profile)

    def every(self, step: int) -> ContactLines:
        """The lines of every `step`-th roll position."""
        by_roll = {
            entry.name: np.ascontiguousarray(getattr(self, entry.name)[::step])
            for entry in dataclasses.fields(self)
            if entry.name not in ("face", "separation")
        }
        return ContactLines(face=self.face, separation=np.ascontiguousarray(self.separation[:, ::step]), **by_roll)

    @classmethod
    def of_rolls(cls, rolls: Sequence[tuple[ContactLines, int]]) -> ContactLines:
        """Lines at roll positions of others, each given by its lines and its number; all have the same stations."""
        by_roll = {
            entry.name: np.stack([getattr(lines, entry.name)[k] for lines, k in rolls])
            for entry in dataclasses.fields(cls)
            if entry.name not in ("face", "separation")
        }
        separation = np.stack([lines.separation[:, k] for lines, k in rolls], axis=1)
        return cls(face=rolls[0][0].face, separation=separation, **by_roll)


def _rounded(radius: float, base_pitch: float) -> float:
    """Radius of an edge [mm], 0 if it is practically sharp."""
    return radius if radius > _SHARP * base_pitch else 0.0


def face_stations(pair: FlankPair, slices: int) -> FloatArray:
    """Middles of equal slices of the driven flank [mm], whole ones between the roundings of both flanks' ends.

    The pair stands at its nominal place, so that every load case has the same slices.
    """
    ends = np.array(pair.face_limits)
    borders, inwards = pair.borders(ends), np.array([1.0, -1.0])
    # the driving flank has face coordinates of its own
    met = pair.meeting(ends, pair.pitch_profile(ends), np.zeros(1)).driving_face
    theirs = np.array(borders.driving_face) + borders.driving_end_edge_radius * inwards
    theirs = ends[0] + (theirs - met[0]) * (ends[1] - ends[0]) / (met[1] - met[0])
    own = ends + borders.end_edge_radius * inwards
    whole = max(own[0], theirs.min()), min(own[1], theirs.max())
    return slice_middles(pair.face_limits, whole, slices)


def end_rounding(distance: FloatArray, radius: float) -> FloatArray:
    """Gap that a rounded end edge adds [mm].

    Parameters
    ----------
    distance : array [mm]
        From the nominal end into the flank; negative outside.
    radius : float [mm]
        Radius of the edge. The rounding begins one radius inside the end (the outline turns by 90 degrees).

    Returns
    -------
    array [mm]
        Zero inside, the sagitta of the arc in the rounding, infinite outside.
    """
    into = np.maximum(radius - distance, 0.0)
    sagitta = radius - np.sqrt(np.maximum(radius**2 - into**2, 0.0))
    return np.where(into > radius, np.inf, sagitta)


def change_along_line(
    values: FloatArray, face: FloatArray, profile: FloatArray, low: FloatArray, high: FloatArray
) -> FloatArray:
    """Derivative by the face coordinate of (roll, face, ...) values along contact lines.

    A line has a kink where it runs onto a border of either flank: no difference is taken across it.
    """
    if face.size < 2:
        return np.zeros_like(values)
    change = np.gradient(values, face, axis=1)
    onward = np.diff(values, axis=1) / np.diff(face).reshape(-1, *[1] * (values.ndim - 2))
    side = (profile >= high).astype(np.int8) - (profile <= low)
    alike = side[:, 1:] == side[:, :-1]
    bends = np.ones((len(alike), 1), dtype=bool), ~alike  # nor across the ends of a line
    before, after = np.concatenate(bends, axis=1), np.concatenate(bends[::-1], axis=1)
    at = np.nonzero(before & ~after)
    change[at] = onward[at]
    at = np.nonzero(after & ~before)
    change[at] = onward[at[0], at[1] - 1]
    return change


def _start_of_line(
    pair: FlankPair, roll: FloatArray, face: FloatArray, root: FloatArray, tip: FloatArray, driving_tip: float
) -> tuple[FloatArray, FloatArray]:
    """Lower end of each slice, and a first guess of where the separation is least."""
    fraction = np.linspace(0.0, 1.0, _SAMPLES)
    samples = root[:, None] + (tip - root)[:, None] * fraction
    met = pair.meeting(face[None, :, None], samples[None], roll[:, None, None])
    beyond = met.driving_profile > driving_tip
    # the driving body's tip cuts the slice between the last sample beyond it and the next (profile grows to the tip)
    last = np.where(beyond.any(axis=-1), _SAMPLES - 1 - np.argmax(beyond[..., ::-1], axis=-1), 0)
    last = np.minimum(last, _SAMPLES - 2)
    take = np.take_along_axis
    value_0 = take(met.driving_profile, last[..., None], -1)[..., 0]
    value_1 = take(met.driving_profile, last[..., None] + 1, -1)[..., 0]
    wide = np.broadcast_to(samples[None], met.driving_profile.shape)
    place_0 = take(wide, last[..., None], -1)[..., 0]
    place_1 = take(wide, last[..., None] + 1, -1)[..., 0]
    # inside the driving body's base circle, where its flank ends, values are constant along a slice
    slope = (value_1 - value_0) / (place_1 - place_0)
    slope = np.where(slope == 0.0, np.inf, slope)
    cut = place_0 + (driving_tip - value_0) / slope
    # once more, by the secant, to some nanometres
    value = pair.meeting(face[None, :], cut, roll[:, None]).driving_profile
    cut = cut - (value - driving_tip) / slope
    low = np.where(beyond.any(axis=-1), np.clip(cut, root, tip), root)
    separation = np.where(beyond, np.inf, met.separation)
    best = np.clip(np.argmin(separation, axis=-1), 1, _SAMPLES - 2)
    left, middle, right = (take(met.separation, best[..., None] + k, -1)[..., 0] for k in (-1, 0, 1))
    curvature = left - 2.0 * middle + right
    shift = np.where(curvature > 0.0, 0.5 * (left - right) / np.where(curvature > 0.0, curvature, 1.0), 0.0)
    guess = take(wide, best[..., None], -1)[..., 0] + np.clip(shift, -1.5, 1.5) * (tip - root) / (_SAMPLES - 1)
    return low, np.clip(guess, low, tip)


def _beyond_the_tip(pair: FlankPair, roll: FloatArray, face: FloatArray) -> BoolArray:
    """Slices beyond the nominal tip of the driving flank, (roll, face)."""
    borders = pair.borders(face, sharp=True)
    return pair.meeting(face[None], borders.tip[None], roll[:, None]).driving_profile > borders.driving_tip


def trace_contact_lines(pair: FlankPair, roll: FloatArray, face: FloatArray, *, sharp: bool = False) -> ContactLines:
    """Contact lines of a pair at roll positions [1] in slices at face stations [mm].

    With `sharp` the flanks end at their nominal edges, otherwise where the rounding of the edges begins.
    """
    borders = pair.borders(face, sharp=sharp)
    low, guess = _start_of_line(pair, roll, face, borders.root, borders.tip, borders.driving_tip)
    high = np.broadcast_to(borders.tip, low.shape)
    normal_step = _STEP * float(np.mean(borders.tip - borders.root))
    least = least_places(pair, roll, face, guess, normal_step, (low, high))
    met, step, profile = least.met, least.step, least.profile
    moved = profile - least.at
    f, first, second, third, fourth = least.derivatives
    separation = np.stack(
        [
            f + first * moved + 0.5 * second * moved**2 + third * moved**3 / 6.0 + fourth * moved**4 / 24.0,
            first + second * moved + 0.5 * third * moved**2 + fourth * moved**3 / 6.0,
            second + third * moved + 0.5 * fourth * moved**2,
            third + fourth * moved,
            fourth,
        ]
    )
    separation = with_far_terms(pair, roll, face, least, normal_step, separation)
    position, slope = met.position[2], (met.position[3] - met.position[1]) / (2.0 * step[..., None])
    position = position + slope * moved[..., None]

    along_face = change_along_line(position, face, profile, low, high)
    per_face = np.linalg.norm(along_face, axis=-1)
    tangent = along_face / per_face[..., None]
    normal_to_line = slope - np.sum(slope * tangent, axis=-1)[..., None] * tangent
    spacing = np.linalg.norm(normal_to_line, axis=-1)
    normal_to_line /= spacing[..., None]
    length = per_face * np.gradient(face)
    arc = np.cumsum(length, axis=1) - 0.5 * length

    velocity = pair.sliding(met.position[1:4:2])
    components = np.stack([np.sum(velocity * normal_to_line, -1), np.sum(velocity * tangent, -1)], axis=-1)
    sliding_slope = (components[1] - components[0]) / (2.0 * step[..., None])
    sliding = 0.5 * (components[0] + components[1]) + sliding_slope * moved[..., None]

    driving_slope = (met.driving_profile[3] - met.driving_profile[1]) / (2.0 * step)
    driving_face = met.driving_face[2]
    keep = 0.0 if sharp else 1.0
    ends = end_rounding(np.minimum(face - borders.face[0], borders.face[1] - face), keep * borders.end_edge_radius)
    driving_ends = end_rounding(
        np.minimum(driving_face - borders.driving_face[0], borders.driving_face[1] - driving_face),
        keep * borders.driving_end_edge_radius,
    )
    separation[0] += ends + driving_ends
    separation[0][_beyond_the_tip(pair, roll, face)] = np.inf
    return ContactLines(
        roll=roll,
        face=face,
        profile=profile,
        low=low,
        high=np.array(high),
        separation=separation,
        spacing=spacing,
        length=length,
        arc=arc,
        sliding=sliding,
        sliding_slope=sliding_slope,
        lever_arm=pair.lever_arm(position),
        driving_profile=met.driving_profile[2] + driving_slope * moved,
        driving_slope=driving_slope,
        driving_face=np.ascontiguousarray(driving_face),
        low_edge_radius=np.where(low > borders.root, _rounded(borders.driving_tip_edge_radius, pair.base_pitch), 0.0),
        high_edge_radius=np.full(low.shape, _rounded(borders.tip_edge_radius, pair.base_pitch)),
    )
