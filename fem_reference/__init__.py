"""Three-dimensional finite-element cross-check of the fast core (scikit-fem).

A contact model of several teeth of both bodies that computes pressure, load sharing, root stress, transmission error
and wear independently of the core. It imports `semiwear.scene`, `semiwear.geometry`, `semiwear.results` and
`semiwear.errors`; the core never imports it. Its results have the core's names and dims, so that results can be
subtracted directly.

`loaded_contact` takes face gears and cylindrical pairs, spur or helical, external or internal; `simulate` (wear) and
`tooth_influence` take face gears only. Flanks given as points are not meshed.
"""

from __future__ import annotations

from fem_reference.abaqus import write_inp
from fem_reference.influence import tooth_influence
from fem_reference.loaded import loaded_contact
from fem_reference.simulation import simulate
from fem_reference.worn_meshes import FlankLoad, WornBody, worn_body

__all__ = ["FlankLoad", "WornBody", "loaded_contact", "simulate", "tooth_influence", "worn_body", "write_inp"]
