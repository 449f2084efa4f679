"""Surface and mesh of a cylindrical gear, pinion or gear, external or internal.

The mesh lies in the body's own frame (`involute_flank`). Face stations are planes of constant z. The section
coordinates are the angle from the middle of the tooth, positive to the loaded side, times the reference radius, and
the radius, less than zero where teeth point inwards, so that it grows towards the tip.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from math import pi

import numpy as np
from scipy.spatial.transform import Rotation

from fem_reference.arrays import FloatArray
from fem_reference.hexahedra import MeshError
from fem_reference.involute_flank import InvoluteFlank
from fem_reference.tooth_mesh import Divisions, Refinement, ToothMesh, mesh_teeth

_FILLET_POINTS = 161


@dataclass(frozen=True)
class CylindricalSurface:
    """A cylindrical gear as `mesh_teeth` sees it (a `ToothSurface`)."""

    own: InvoluteFlank
    face_limits: tuple[float, float]
    name: str

    def half_pitch(self, face: float) -> float:
        """Half a pitch on the reference circle [mm]."""
        return pi * self.own.tooth.reference_radius / self.own.tooth.teeth

    @property
    def foot(self) -> float:
        """Section height of the held bore, or of the held outside of an internal gear [mm]."""
        tooth = self.own.tooth
        return tooth.side * tooth.root_radius - tooth.rim_thickness

    def profile_limits(self, face: float) -> tuple[float, float]:
        """Profile coordinate of the lower end of the involute and of the tip [mm]."""
        tooth = self.own.tooth
        if tooth.half_thickness(tooth.tip_radius) <= 0.0:
            raise MeshError(
                f"{self.name}: the tooth is pointed at its tip; see gear_pair.{self.name}_tip_diameter_mm"
            )
        if tooth.form_roll_angle <= 0.0:
            raise MeshError(f"{self.name}: the tooth is undercut; raise gear_pair.{self.name}_profile_shift")
        return self.own.root_profile, float(self.own.tip_profile(np.array(0.0)))

    def flank(self, profile: FloatArray, face: float) -> tuple[FloatArray, FloatArray]:
        """Section points (n, 2) of the loaded flank and normals (n, 3): along the arc, the height, the axis."""
        tooth, roll = self.own.tooth, self.own.roll_from_profile(profile)
        radius = tooth.base_radius * np.sqrt(1.0 + roll**2)
        section = np.column_stack([self.own.half_angle(roll) * tooth.reference_radius, tooth.side * radius])
        return section, self.own.section_normal(roll)

    def fillet(self, face: float) -> FloatArray:
        """Section points (k, 2) of the fillet, from the end of the involute to the root circle."""
        tooth = self.own.tooth
        angle, radius = self.own.fillet(_FILLET_POINTS)
        return np.column_stack([angle * tooth.reference_radius, tooth.side * radius])

    def to_space(self, section: FloatArray, face: float, tooth: int) -> FloatArray:
        """Points (..., 3) of section points (..., 2) of a tooth [mm]."""
        polar, radius = self._polar(section[..., 0], face, tooth), np.abs(section[..., 1])
        return np.stack([radius * np.sin(polar), -radius * np.cos(polar), np.full_like(polar, face)], axis=-1)

    def directions(self, across: FloatArray, face: float, tooth: int) -> FloatArray:
        """Unit vectors (..., 3, 3) along the arc, the height and the axis at section coordinates `across`."""
        return self.own.directions(self._polar(across, face, tooth))

    def _polar(self, across: FloatArray, face: float, tooth: int) -> FloatArray:
        """Polar angle from -y towards +x [rad]."""
        body = self.own.tooth
        angle = across / body.reference_radius + 2.0 * pi * tooth / body.teeth
        return self.own.facing * angle + self.own.twist * face


def cylindrical_mesh(
    surface: CylindricalSurface,
    *,
    module: float,
    element: str = "hex8i",
    teeth: int | None = None,
    refinements: Mapping[int, Refinement] | None = None,
    divisions: Divisions | None = None,
    detailed: Iterable[int] = (0,),
    explicit: int | None = None,
) -> ToothMesh:
    """Mesh a cylindrical gear.

    Parameters
    ----------
    surface : CylindricalSurface
    module : float
        Normal module, which gives the element sizes unless `divisions` does [mm].
    teeth : int, optional
        Number of teeth of a sector with free cut planes; default the whole ring.
    explicit : int, optional
        Of the whole ring (no `teeth` given), teeth on either side of tooth 0 that are in the mesh; the others, which
        carry no load, are condensed (`ToothMesh.rest`). Default all. Refined teeth, and what lies between them,
        always are in the mesh.
    element, refinements, divisions, detailed
        As for `face_gear_mesh`.

    Raises
    ------
    MeshError
        Where the tooth is pointed or undercut, or an element is folded.
    """
    whole = int(surface.own.tooth.teeth)
    count = whole if teeth is None else min(teeth, whole)
    members = range(-((count - 1) // 2), count // 2 + 1)
    missing, turn = 0, None
    if explicit is not None and teeth is None:
        meshed = [-explicit, explicit, *(refinements or {}), *detailed]
        if max(meshed) - min(meshed) + 1 < whole:
            members = range(min(meshed), max(meshed) + 1)
            missing = whole - len(members)
            turn = Rotation.from_rotvec([0.0, 0.0, surface.own.facing * 2.0 * pi / whole]).as_matrix()
    divisions = divisions or Divisions.of_module(module)
    mesh = mesh_teeth(
        surface, members, element, refinements or {}, divisions, tuple(detailed), missing=missing, turn=turn
    )
    return replace(mesh, inclined=True)
