"""Slices of a contact line whose load and speeds are given outright: input of friction, heat and wear laws."""

import numpy as np
from numpy.typing import ArrayLike

from semiwear.contact.conditions import ContactConditions

HALF_WIDTH = 0.15
"""Of every loaded slice [mm]."""


def line_state(
    load: ArrayLike,
    driving: ArrayLike,
    driven: ArrayLike,
    *,
    sliding: ArrayLike | None = None,
    half_width: float = HALF_WIDTH,
    curvature: ArrayLike = 0.1,
    pressure: ArrayLike = 900.0,
) -> ContactConditions:
    """One roll position of slices; those without load have no width, curvature or pressure."""
    load, driving, driven, pressure, curvature = np.broadcast_arrays(
        *(np.atleast_2d(np.asarray(values, float)) for values in (load, driving, driven, pressure, curvature))
    )
    return ContactConditions(
        line_load=load,
        half_width=np.where(load > 0.0, half_width, 0.0),
        curvature=np.where(load > 0.0, curvature, 0.0),
        pressure=np.where(load > 0.0, pressure, 0.0),
        surface_speed=np.stack([driving, driven]),
        sliding_speed=np.abs(driving - driven) if sliding is None else np.broadcast_to(sliding, load.shape) * 1.0,
    )
