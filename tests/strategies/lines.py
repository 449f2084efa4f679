"""Contact lines of no gear in particular: straight, parallel, on a plane flank."""

import numpy as np

from semiwear.meshing.contact_lines import ContactLines
from semiwear.meshing.flank_grid import FlankGrid


def straight_lines(
    place: np.ndarray,
    slices: int,
    *,
    step: float = 1.0,
    across: float = 0.0,
    along: float = 0.0,
    half_height: float = 10.0,
    lever: float = 1.0,
    sliding: np.ndarray | float = 0.0,
    sliding_slope: float = 0.0,
) -> ContactLines:
    """One line for each profile coordinate in `place` [mm], all its slices alike but for the curvature along it.

    Curvatures [1/mm] are relative ones, `step` is the length of a slice [mm]; sliding is normal to the line.
    """
    roll = np.linspace(-0.5, 0.5, place.size)
    one = np.ones((place.size, slices))
    arc = step * (np.arange(slices) + 0.5) * one
    separation = np.zeros((5, place.size, slices))
    separation[0], separation[2] = 0.5 * along * (arc - 0.5 * step * slices) ** 2, across
    velocity = np.zeros((place.size, slices, 2))
    velocity[..., 0] = np.reshape(sliding, (-1, 1))
    slope = np.zeros((place.size, slices, 2))
    slope[..., 0] = sliding_slope
    return ContactLines(
        roll=roll,
        face=arc[0].copy(),
        profile=place[:, None] * one,
        low=-half_height * one,
        high=half_height * one,
        separation=separation,
        spacing=one,
        length=step * one,
        arc=arc,
        sliding=velocity,
        sliding_slope=slope,
        lever_arm=lever * one,
        driving_profile=place[:, None] * one,
        driving_slope=one,
        driving_face=arc,
        low_edge_radius=0.0 * one,
        high_edge_radius=0.0 * one,
    )


def even_grid(lines: ContactLines, points: int) -> FlankGrid:
    """Evenly spaced nodes from the lower to the upper end of the flank; the middle one splits it."""
    nodes = np.linspace(lines.low[0, 0], lines.high[0, 0], points)
    slices = lines.face.size
    return FlankGrid(lines.face, np.tile(nodes, (slices, 1)), np.full(slices, points // 2))
