"""Pitch point and pitch surfaces of two bodies on axes that may lie anywhere.

With parallel or intersecting axes the bodies' relative motion is a pure rotation about their instantaneous axis: the
pitch surfaces are the cylinders or cones that it sweeps, and the pitch point is its point next to the contact. With
crossed axes it is a screw, nothing rolls without sliding, and the pitch point may be chosen (Litvin and Fuentes 2004,
Gear Geometry and Applied Theory, ch. 3 and 21.4): it is the contact itself where the flanks do not slide across the
teeth but along them, and the pitch surfaces are the cones through it along the teeth of either body.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semiwear.arrays import FloatArray

_SMALL = 1e-9


@dataclass(frozen=True)
class PitchSurface:
    """A cone (or cylinder, or plane) about a body's axis.

    Attributes
    ----------
    radius, axial : float [mm]
        A point of it: distance from the axis, and place along it.
    normal : (float, float)
        Unit normal there towards the tips of the teeth: radial and axial part.
    """

    radius: float
    axial: float
    normal: tuple[float, float]

    def height(self, radius: FloatArray, axial: FloatArray) -> FloatArray:
        """Distance from the surface, positive towards the tips [mm]."""
        return (radius - self.radius) * self.normal[0] + (axial - self.axial) * self.normal[1]


Motion = tuple[FloatArray, FloatArray]
"""Angular velocity of a body, and a point of its axis."""


def meet_in_a_point(first: Motion, second: Motion) -> bool:
    """Whether two axes intersect or are parallel."""
    (a, p), (b, q) = first, second
    across = np.cross(a / np.linalg.norm(a), b / np.linalg.norm(b))
    if np.linalg.norm(across) < _SMALL:
        return True
    size = max(float(np.linalg.norm(q - p)), 1.0)
    return bool(abs((q - p) @ across) / np.linalg.norm(across) < _SMALL * size)


def pitch_point(first: Motion, second: Motion, contact: FloatArray) -> FloatArray:
    """The pitch point that belongs to a contact point [mm]."""
    if not meet_in_a_point(first, second):
        return contact
    turn = first[0] - second[0]
    moment = np.cross(first[0], first[1]) - np.cross(second[0], second[1])
    # where the relative velocity, turn x place - moment, vanishes
    foot = np.cross(moment, turn) / (turn @ turn)
    along = turn / np.linalg.norm(turn)
    return np.asarray(foot + along * (along @ (contact - foot)))


def instantaneous_axis(first: Motion, second: Motion) -> FloatArray | None:
    """Direction of the instantaneous axis of the relative motion; None with crossed axes."""
    if not meet_in_a_point(first, second):
        return None
    turn = first[0] - second[0]
    return np.asarray(turn / np.linalg.norm(turn))


def pitch_surface(
    frame: FloatArray, centre: FloatArray, point: FloatArray, along: FloatArray, tips: FloatArray
) -> PitchSurface:
    """Pitch surface of a body: the surface of revolution of a straight line.

    Parameters
    ----------
    frame, centre : (3, 3), (3,) arrays
        Columns: the body's own axes in the fixed frame; and its origin [mm].
    point, along : (3,) arrays
        The pitch point [mm], and a direction of the surface there other than round the axis, in the fixed frame.
    tips : (2,) array
        Radial and axial part of a direction that leads towards the tips.
    """
    own, direction = (point - centre) @ frame, along @ frame
    radius = float(np.hypot(own[0], own[1]))
    radial, axial = float(direction[:2] @ own[:2]) / radius, float(direction[2])
    size = float(np.hypot(radial, axial))
    normal = np.array([axial, -radial]) / size
    if normal @ tips < 0.0:
        normal = -normal
    return PitchSurface(radius, float(own[2]), (float(normal[0]), float(normal[1])))
