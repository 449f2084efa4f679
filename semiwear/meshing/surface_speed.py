"""Velocities of both surfaces through the fresh contact lines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.meshing.contact_lines import ContactLines, change_along_line, trace_contact_lines
from semiwear.meshing.flank_pair import FlankPair

_SHIFT = 0.01  # roll positions before and after, between which a speed is measured
_PARTS = 8  # even parts of a slice: on an oblique line sliding vanishes in one slice after another


def line_speed(pair: FlankPair, lines: ContactLines) -> tuple[FloatArray, FloatArray]:
    """Speed of fresh lines over the driven flank, and whether they move towards its tip (+1) or root (-1).

    Measured between lines traced a little before and after each roll position. Where a line turns in between, the
    speed is that of its whole path.

    Returns
    -------
    speed, direction : (roll, face) arrays [mm per roll], [1]
    """
    before, after = (trace_contact_lines(pair, lines.roll + shift, lines.face) for shift in (-_SHIFT, _SHIFT))
    moved = np.abs(lines.profile - before.profile) + np.abs(after.profile - lines.profile)
    return 0.5 * moved / _SHIFT * lines.spacing, np.sign(after.profile - before.profile)


@dataclass(frozen=True)
class SurfaceSpeeds:
    """Velocities in fresh contact lines.

    Attributes
    ----------
    surface : (2, roll, face) array [mm/s]
        Of the driving and the driven surface, across the line and relative to it; towards the driven tip positive.
    sliding : (roll, face) array [mm/s]
        Magnitude of the sliding velocity.
    sliding_in_parts : (part, roll, face) array [mm/s]
        The same in the middles of even parts of each slice.
    sliding_with_driving : (part, roll, face) array [mm^2/s]
        Product of the sliding velocity there and the velocity of the driving surface per unit angular velocity: over
        `sliding_in_parts` it is the moment about the driving axis of a unit friction force, positive where that has
        to be driven.
    power_per_torque : float [1/s]
        Angular velocity of the driving body.
    """

    surface: FloatArray
    sliding: FloatArray
    sliding_in_parts: FloatArray
    sliding_with_driving: FloatArray
    power_per_torque: float

    @classmethod
    def of(cls, pair: FlankPair, lines: ContactLines, angular_velocity: float) -> SurfaceSpeeds:
        """Speeds at an angular velocity of the driving body [rad/s]."""
        speed, direction = line_speed(pair, lines)
        over_driven = direction * speed * pair.roll_per_time
        surface = np.stack([lines.sliding[..., 0] - over_driven, -over_driven])
        face = np.broadcast_to(lines.face, lines.profile.shape)
        met = pair.meeting(face, lines.profile, lines.roll[:, None])
        relative = pair.sliding(met.position)
        driving = relative + pair.driven_velocity(met.position)
        # where an edge presses the flanks also part or approach
        slip = relative - np.sum(relative * met.normal, axis=-1, keepdims=True) * met.normal
        parts = ((np.arange(_PARTS) + 0.5) / _PARTS - 0.5)[:, None, None, None]
        width = np.gradient(lines.face)[:, None]
        # velocities of rigid bodies are linear in place, and places along a line are nearly so
        slip, driving = (
            v + parts * width * change_along_line(v, lines.face, lines.profile, lines.low, lines.high)
            for v in (slip, driving)
        )
        return cls(
            angular_velocity * surface,
            angular_velocity * np.hypot(lines.sliding[..., 0], lines.sliding[..., 1]),
            angular_velocity * np.linalg.norm(slip, axis=-1),
            angular_velocity * np.sum(slip * driving, axis=-1),
            angular_velocity,
        )
