"""The plainest tooth section: what finite prisms, their ends and their wheel are tried on."""

import numpy as np

from semiwear.geometry.section import RackRim, ToothSection


def trapezoid(
    height: float = 14.0,
    half_tip: float = 2.5,
    angle: float = 20.0,
    radius: float = 2.0,
    pitch: float = 20.0,
    rim: float = 15.0,
    points: int = 41,
) -> ToothSection:
    """Straight flanks, circular fillets, root at y = 0, plane rim."""
    angle = np.radians(angle)
    centre = np.array([half_tip + (height - radius) * np.tan(angle) + radius / np.cos(angle), radius])
    around = np.linspace(np.pi + angle, 1.5 * np.pi, points)
    fillet = centre + radius * np.stack([np.cos(around), np.sin(around)], axis=1)
    y = np.linspace(height, fillet[0, 1], points)
    flank = np.stack([half_tip + (height - y) * np.tan(angle), y], axis=1)
    return ToothSection(flank, y, fillet, RackRim(pitch, -rim))
