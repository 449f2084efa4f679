"""A spur pair by the formulas of ISO 21771, ISO 6336-2 and ISO 6336-1, beside what the core finds."""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, cos, degrees, pi, radians, sin, sqrt

import numpy as np

import semiwear as sw
from semiwear.closed_forms.hertz import line_contact_pressure
from semiwear.errors import SemiwearError
from semiwear.meshing.cylindrical_pair import CylindricalMesh
from semiwear.meshing.tooth_contact import contact_points
from semiwear.plan import plan
from semiwear.scene import CylindricalPair, Scene
from semiwear.wear.swept_line import fresh_sweep


@dataclass(frozen=True)
class IsoRow:
    """A quantity by a closed form and by the core.

    Attributes
    ----------
    name, source, units : str
    closed_form, core : float
    """

    name: str
    source: str
    units: str
    closed_form: float
    core: float

    @property
    def difference(self) -> float:
        """Core less closed form, relative."""
        return self.core / self.closed_form - 1.0


def iso_rows(scene: Scene) -> list[IsoRow]:
    """Closed forms of an external spur pair beside the core's results.

    Raises
    ------
    SemiwearError
        The scene is not an external spur pair.
    """
    table = scene.gear_pair
    if not isinstance(table, CylindricalPair) or table.helix_angle_deg or table.gear_teeth < 0:
        raise SemiwearError("closed forms: the scene is no external spur pair; choose spur_fzg_c or one like it")
    scene = scene.replace({"wear": None})
    physics = plan(scene)
    pair = physics.flank_pair()
    assert isinstance(pair, CylindricalMesh)

    # ISO 21771: working pressure angle, base pitch, path of contact and contact ratio
    z, module, alpha = (
        (table.pinion_teeth, table.gear_teeth),
        table.normal_module_mm,
        radians(table.pressure_angle_deg),
    )
    base = [0.5 * module * teeth * cos(alpha) for teeth in z]
    working = acos(sum(base) / table.centre_distance_mm)
    pitch = pi * module * cos(alpha)
    radii = [one / cos(working) for one in base]
    tips = [0.5 * table.pinion_tip_diameter_mm, 0.5 * table.gear_tip_diameter_mm]
    # distances of the ends of the path from the pitch point: the pinion's tip, the gear's tip
    recess, approach = (sqrt(tip**2 - b**2) - r * sin(working) for tip, b, r in zip(tips, base, radii, strict=True))
    contact = sw.tooth_contact_analysis(scene)
    ratio = float(contact["contact_ratio"])
    rows = [
        IsoRow("working pressure angle", "ISO 21771", "deg", degrees(working), degrees(table.working_pressure_angle)),
        IsoRow("base pitch", "ISO 21771", "mm", pitch, pair.base_pitch),
        IsoRow("contact ratio, followed without the formula", "ISO 21771", "1", (recess + approach) / pitch, ratio),
    ]

    # ISO 21771, 5.6: specific sliding: difference of the speeds over the flanks, over the own one
    lines = physics.loaded_teeth().fine
    sliding = fresh_sweep(pair, lines).specific_sliding[:, lines.face.size // 2]
    for name, travel in (("half-way to the gear's tip", 0.5 * approach), ("half-way to its root", -0.5 * recess)):
        rho = (radii[0] * sin(working) - travel, radii[1] * sin(working) + travel)
        speeds = (rho[0] / z[0], rho[1] / z[1])
        expected = abs(speeds[0] - speeds[1]) / speeds[1]
        found = float(np.interp(-travel / pitch, lines.roll, sliding))
        rows.append(IsoRow(f"specific sliding of the gear, {name}", "ISO 21771", "1", expected, found))

    # ISO 6336-2: nominal contact stress at the pitch point, all the load on one pair
    tangential = 2e3 * scene.operation.pinion_torque_Nm / (module * z[0])
    zone = sqrt(2.0 * cos(working) / (cos(alpha) ** 2 * sin(working)))
    compliance = sum(
        (1.0 - m.poissons_ratio**2) / m.youngs_modulus_MPa for m in (scene.material.pinion, scene.material.gear)
    )
    elasticity = sqrt(1.0 / (pi * compliance))
    width, ratio_of_teeth = table.pinion_face_width_mm, z[1] / z[0]
    nominal = zone * elasticity * sqrt(tangential / (module * z[0] * width) * (ratio_of_teeth + 1.0) / ratio_of_teeth)
    force = 1e3 * scene.operation.pinion_torque_Nm / base[0]
    curvature = contact_points(pair, np.zeros(1)).curvature[0, 1]
    even = float(line_contact_pressure(np.array(force / width), curvature, physics.modulus))
    rows.append(IsoRow("pressure at the pitch point, even load", "ISO 6336-2", "MPa", nominal, even))
    alone = sw.loaded_contact(scene.replace({"numerics.tooth_pairs": 1}), [0.0])
    engagement = alone["engagement"].to_dataset()
    at_pitch = int(np.abs(engagement["roll_position"].values).argmin())
    solved = float(engagement["contact_pressure_max"].values[0, at_pitch])
    rows.append(IsoRow("the same, load along the face solved", "ISO 6336-2", "MPa", nominal, solved))

    # ISO 6336-1, method B: theoretical single stiffness, a fit to Weber and Banaschek
    deflection = -1e3 * float(alone["mesh_cycle"]["transmission_error_loaded"].mean()) / pair.arcsec_per_mm
    stiffness = _single_stiffness(*z, table.pinion_profile_shift, table.gear_profile_shift)
    found = force / width / deflection
    rows.append(IsoRow("single stiffness, to the bore and the rim", "ISO 6336-1 B", "N/(mm um)", stiffness, found))
    return rows


def _single_stiffness(z1: float, z2: float, x1: float, x2: float) -> float:
    """Theoretical single stiffness c'_th = 1/q' [N/(mm um)] (ISO 6336-1:2019, method B, external teeth)."""
    flexibility = 0.04723 + 0.15551 / z1 + 0.25791 / z2 - 0.00635 * x1 - 0.11654 * x1 / z1 - 0.00193 * x2
    flexibility += -0.24188 * x2 / z2 + 0.00529 * x1**2 + 0.00182 * x2**2
    return 1.0 / flexibility
