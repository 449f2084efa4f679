"""Conditions in the contact lines of loaded teeth, from their loads and the motion of their surfaces."""

from __future__ import annotations

from math import pi

import numpy as np

from semiwear.contact.conditions import ContactConditions
from semiwear.contact.footprint import Footprints
from semiwear.contact.loads import TeethLoads
from semiwear.contact.problem import ContactProblem
from semiwear.meshing.surface_speed import SurfaceSpeeds


def line_conditions(
    problem: ContactProblem, loads: TeethLoads, worn: Footprints, speeds: SurfaceSpeeds
) -> ContactConditions:
    """Conditions in every slice.

    Parameters
    ----------
    problem : ContactProblem
    loads : TeethLoads
    worn : Footprints
    speeds : SurfaceSpeeds
        At the same roll positions.
    """
    line_load, half_width = problem.line_load(loads), loads.half_width
    width = np.where(half_width > 0.0, half_width, 1.0)
    return ContactConditions(
        line_load=np.where(half_width > 0.0, line_load, 0.0),
        half_width=half_width,
        curvature=worn.curvature,
        pressure=2.0 * line_load / (pi * width),
        surface_speed=speeds.surface,
        sliding_speed=speeds.sliding,
    )
