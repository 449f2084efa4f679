"""Pictures of a result: functions that take a tree and return matplotlib axes (extra ``plot``).

Each name of `__all__` draws one result; `against` holds pictures of two, `measured_wear` draws a comparison with a
measurement, `geometry_figure` and its parts a scene before it runs, `sweep_curves`, `sweep_map` and `sweep_samples` a
sweep, `posterior_corner` an inference, and `safety_history` and `safety_map` the failure modes of a result.
"""

from __future__ import annotations

from semiwear.plot import against as against
from semiwear.plot.engagement import (
    contact_pressure_over_engagement,
    load_share,
    sliding_along_path,
    transmission_error_curves,
)
from semiwear.plot.flank import contact_pattern, wear_map, wear_profiles
from semiwear.plot.geometry import geometry_figure as geometry_figure
from semiwear.plot.geometry import path_on_flank as path_on_flank
from semiwear.plot.geometry import teeth_in_mesh as teeth_in_mesh
from semiwear.plot.geometry import tooth_sections as tooth_sections
from semiwear.plot.history import (
    contact_stress_history,
    meshes_against_depth,
    root_stress_history,
    transmission_error_history,
    wear_history,
)
from semiwear.plot.measured import measured_wear as measured_wear
from semiwear.plot.posterior import posterior_corner as posterior_corner
from semiwear.plot.ratings import safety_history as safety_history
from semiwear.plot.ratings import safety_map as safety_map
from semiwear.plot.sweeps import sweep_curves as sweep_curves
from semiwear.plot.sweeps import sweep_map as sweep_map
from semiwear.plot.sweeps import sweep_samples as sweep_samples
from semiwear.plot.worn_surface import wear_surface

__all__ = [
    "contact_pattern",
    "contact_pressure_over_engagement",
    "contact_stress_history",
    "load_share",
    "meshes_against_depth",
    "root_stress_history",
    "sliding_along_path",
    "transmission_error_curves",
    "transmission_error_history",
    "wear_history",
    "wear_map",
    "wear_profiles",
    "wear_surface",
]
