"""The search for the length of a wear step at whose end the control point has worn to a depth."""

from __future__ import annotations

import numpy as np

from semiwear.arrays import IntArray
from semiwear.contact.loaded_teeth import LoadedTeeth
from semiwear.meshing.flank_pair import DRIVING
from semiwear.wear.state import ControlPoint, WearState

_LEAST_SLOPE = 0.1  # speed of the line on the driving flank over that on the driven flank; 1 in pure rolling


def positions_at(
    teeth: LoadedTeeth, half_width: float, state: WearState, point: ControlPoint, slices: IntArray
) -> list[int]:
    """Mesh positions whose footprints in some slices can reach the control point.

    For a point of the driving flank these are the positions at which its station meets loaded slices.

    Parameters
    ----------
    teeth : LoadedTeeth
    half_width : float [mm]
        Of the footprints on which wear is deposited.
    state : WearState
    point : ControlPoint
    slices : int array
    """
    lines, touched = teeth.lines, state.contact.coarse.profile
    near = np.any([contact.loads.force > 0.0 for contact in state.loaded], axis=0)
    if point.body == DRIVING:
        face = teeth.grid.face
        near &= np.abs(lines.driving_face - point.face) < face[1] - face[0]
        distance = lines.on_driving(touched) - np.interp(lines.driving_face, face, point.profile)
        spacing = lines.spacing / np.maximum(np.abs(lines.driving_slope), _LEAST_SLOPE)
        spacing = np.where(near, spacing, np.inf)
    else:
        near, distance = near[:, slices], (touched - point.profile)[:, slices]
        spacing = lines.spacing[:, slices]
    reach = 3.0 * max(teeth.half_width, half_width) / float(spacing.min())
    near &= np.abs(distance) <= reach
    rolls = np.flatnonzero(near.any(axis=1))
    # loads are interpolated between positions, so neighbouring positions are needed as well
    rolls = np.unique(np.clip(np.concatenate([rolls - 1, rolls, rolls + 1]), 0, distance.shape[0] - 1))
    return [int(position) for position in np.unique(rolls % teeth.rolls.phase.size)]


def next_trial(tried: list[tuple[float, float]]) -> float:
    """Next trial for the zero of a rising function, from arguments and values: a secant kept within its bracket."""
    below = max(x for x, y in tried if y < 0.0)
    above = min((x for x, y in tried if y >= 0.0), default=4.0 * max(x for x, _ in tried))
    (x_0, y_0), (x_1, y_1) = tried[-2:]
    secant = x_1 - y_1 * (x_1 - x_0) / (y_1 - y_0) if y_1 != y_0 else above
    margin = 1e-3 * (above - below)
    if below + margin < secant < above - margin or abs(y_1) < 1e-3 * abs(tried[0][1]):
        return min(max(secant, below), above)
    return 0.5 * (below + above) if len(tried) > 3 else min(max(secant, below + margin), above - margin)
