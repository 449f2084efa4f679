"""The shipped pair, aligned: how its bodies move and how large its flanks are, from motions and points alone."""

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.meshing.flank_grid import FlankGrid
from semiwear.meshing.flank_pair import FlankPair

PINION_TEETH, GEAR_TEETH = 25, 160
AXIS_OFFSET = 0.5 * 6.35 * (28 - PINION_TEETH)


def _turned(x: FloatArray, y: FloatArray, angle: float) -> tuple[FloatArray, FloatArray]:
    return x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)


def sliding_speed(position: FloatArray, normal: FloatArray) -> FloatArray:
    """|v_s| [mm per radian of the pinion], by moving both bodies a little; the pinion turns towards -z about z."""
    step = 1e-5
    moved = []
    for angle in (-step, step):
        x, y = _turned(position[..., 0], position[..., 1] + AXIS_OFFSET, -angle)
        pinion = np.stack([x, y - AXIS_OFFSET, position[..., 2]], axis=-1)
        z, x = _turned(position[..., 2], position[..., 0], -angle * PINION_TEETH / GEAR_TEETH)
        moved.append(pinion - np.stack([x, position[..., 1], z], axis=-1))
    slip = (moved[1] - moved[0]) / (2.0 * step)
    slip = slip - np.sum(slip * normal, axis=-1, keepdims=True) * normal
    return np.linalg.norm(slip, axis=-1)


def volume_off_gear(pair: FlankPair, grid: FlankGrid, depth: FloatArray) -> float:
    """Volume of a depth on the gear's grid, by the area of the flank per face and profile coordinate."""
    face, profile, step = grid.face[:, None], grid.profile, 1e-3
    along = (pair.gear.points(face + step, profile)[0] - pair.gear.points(face - step, profile)[0]) / (2.0 * step)
    across = (pair.gear.points(face, profile + step)[0] - pair.gear.points(face, profile - step)[0]) / (2.0 * step)
    area = np.linalg.norm(np.cross(along, across), axis=-1)
    width = (pair.face_limits[1] - pair.face_limits[0]) / grid.face.size
    return width * float(np.trapezoid(depth * area, profile, axis=1).sum())
