"""Stresses of cylindrical pairs as ISO 6336-2 and -3 have them, with all load factors 1 (method B).

Only what a comparison with local stresses needs: external teeth on thick rims, cut by a rack without protuberance.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, atan, cos, degrees, pi, radians, sin, sqrt, tan

from semiwear.scene import CylindricalPair, Scene


@dataclass(frozen=True)
class IsoStresses:
    """Stresses of the standard.

    Attributes
    ----------
    contact : (pinion, gear) [MPa]
        sigma_H at the inner points of single pair contact, or at the pitch point where that is more.
    root : (pinion, gear) [MPa]
        sigma_F of the 2019 edition.
    root_2006 : (pinion, gear) [MPa]
        The same without its load distribution factor and with the helix angle factor of the 2006 edition.
    contact_ratio, overlap_ratio, contact_ratio_factor : float
        The last is Z_epsilon.
    """

    contact: tuple[float, float]
    root: tuple[float, float]
    root_2006: tuple[float, float]
    contact_ratio: float
    overlap_ratio: float
    contact_ratio_factor: float


@dataclass(frozen=True)
class _Mesh:
    """Lengths and angles of a pair (ISO 21771)."""

    teeth: tuple[int, int]
    module: float
    alpha: float
    alpha_t: float
    working: float
    beta: float
    beta_b: float
    reference: tuple[float, float]
    base: tuple[float, float]
    tip: tuple[float, float]
    contact_ratio: float
    overlap_ratio: float


def _mesh(table: CylindricalPair) -> _Mesh:
    teeth = (table.pinion_teeth, table.gear_teeth)
    alpha, beta = radians(table.pressure_angle_deg), radians(abs(table.helix_angle_deg))
    alpha_t = atan(tan(alpha) / cos(beta))
    reference = tuple(table.normal_module_mm * z / cos(beta) for z in teeth)
    base = tuple(d * cos(alpha_t) for d in reference)
    tip = (table.pinion_tip_diameter_mm, table.gear_tip_diameter_mm)
    working = acos(0.5 * sum(base) / table.centre_distance_mm)
    path = sum(0.5 * sqrt(a**2 - b**2) for a, b in zip(tip, base, strict=True))
    path -= table.centre_distance_mm * sin(working)
    return _Mesh(
        teeth,
        table.normal_module_mm,
        alpha,
        alpha_t,
        working,
        beta,
        acos(sqrt(1.0 - (sin(beta) * cos(alpha)) ** 2)),
        (reference[0], reference[1]),
        (base[0], base[1]),
        tip,
        path / (pi * table.normal_module_mm * cos(alpha_t) / cos(beta)),
        _width(table) * sin(beta) / (pi * table.normal_module_mm),
    )


def _width(table: CylindricalPair) -> float:
    return min(table.pinion_face_width_mm, table.gear_face_width_mm)


def iso_stresses(scene: Scene) -> IsoStresses:
    """Stresses of the standard under the scene's torque.

    Source
    ------
    ISO 6336-2:2006, clauses 6 to 9 (contact); ISO 6336-3:2019, clauses 5 to 8, and 2006 (root).
    """
    table = scene.gear_pair
    assert isinstance(table, CylindricalPair) and table.gear_teeth > 0
    mesh = _mesh(table)
    force = 2e3 * scene.operation.pinion_torque_Nm / mesh.reference[0]
    line = force / _width(table)
    shifts = (table.pinion_profile_shift, table.gear_profile_shift)
    racks = [
        (getattr(table, f"{body}_rack_addendum_mm"), getattr(table, f"{body}_rack_tip_radius_mm"))
        for body in ("pinion", "gear")
    ]
    form = [_form_and_correction(mesh, body, shifts[body], *racks[body]) for body in range(2)]
    slant = min(mesh.overlap_ratio, 1.0) * min(degrees(mesh.beta), 30.0) / 120.0
    older = [line / mesh.module * one * (1.0 - slant) for one in form]
    newer = [stress * _load_distribution(mesh) / cos(mesh.beta) ** 3 for stress in older]
    nominal = _contact_stress(scene, mesh, line)
    return IsoStresses(
        (nominal * _single_pair(mesh, 0), nominal * _single_pair(mesh, 1)),
        (newer[0], newer[1]),
        (older[0], older[1]),
        mesh.contact_ratio,
        mesh.overlap_ratio,
        _contact_ratio_factor(mesh),
    )


def _contact_ratio_factor(mesh: _Mesh) -> float:
    """Z_epsilon."""
    overlap = min(mesh.overlap_ratio, 1.0)
    return sqrt((4.0 - mesh.contact_ratio) / 3.0 * (1.0 - overlap) + overlap / mesh.contact_ratio)


def _contact_stress(scene: Scene, mesh: _Mesh, line: float) -> float:
    """sigma_H0 = Z_H Z_E Z_epsilon Z_beta sqrt(F_t/(d_1 b) (u + 1)/u)."""
    ratio = mesh.teeth[1] / mesh.teeth[0]
    zone = sqrt(2.0 * cos(mesh.beta_b) * cos(mesh.working) / (cos(mesh.alpha_t) ** 2 * sin(mesh.working)))
    bodies = (scene.material.pinion, scene.material.gear)
    elastic = sqrt(1.0 / (pi * sum((1.0 - m.poissons_ratio**2) / m.youngs_modulus_MPa for m in bodies)))
    load = line / mesh.reference[0] * (ratio + 1.0) / ratio
    return zone * elastic * _contact_ratio_factor(mesh) * sqrt(load / cos(mesh.beta))


def _single_pair(mesh: _Mesh, body: int) -> float:
    """Z_B of the pinion, Z_D of the gear (2006 edition)."""
    own, other = body, 1 - body

    def turned(at: int, pitches: float) -> float:
        return sqrt((mesh.tip[at] / mesh.base[at]) ** 2 - 1.0) - pitches * 2.0 * pi / mesh.teeth[at]

    m = tan(mesh.working) / sqrt(turned(own, 1.0) * turned(other, mesh.contact_ratio - 1.0))
    return max(1.0, m - min(mesh.overlap_ratio, 1.0) * (m - 1.0))


def _load_distribution(mesh: _Mesh) -> float:
    """f_epsilon of the 2019 edition."""
    virtual, overlap = mesh.contact_ratio / cos(mesh.beta_b) ** 2, mesh.overlap_ratio
    if overlap <= 0.0:
        return 1.0 if virtual < 2.0 else 0.7
    if overlap < 1.0:
        alone = 1.0 if virtual < 2.0 else 0.5  # from two pairs on, half of what a spur tooth bears
        return sqrt(alone * (1.0 - overlap) + overlap / virtual)
    return virtual**-0.5


def _involute(angle: float) -> float:
    return tan(angle) - angle


def _form_and_correction(mesh: _Mesh, body: int, shift: float, addendum: float, radius: float) -> float:
    """Y_F Y_S at the outer point of single pair contact; `addendum` and `radius` are of the rack's tip [mm]."""
    m, alpha, z = mesh.module, mesh.alpha, mesh.teeth[body]
    z_n = z / (cos(mesh.beta_b) ** 2 * cos(mesh.beta))
    rho = radius / m
    space = pi / 4.0 * m - addendum * tan(alpha) - (1.0 - sin(alpha)) * radius / cos(alpha)
    g = rho - addendum / m + shift
    h = 2.0 / z_n * (pi / 2.0 - space / m) - pi / 3.0
    theta = pi / 6.0
    for _ in range(50):
        theta = 2.0 * g / z_n * tan(theta) - h
    chord = z_n * sin(pi / 3.0 - theta) + sqrt(3.0) * (g / cos(theta) - rho)
    fillet = rho + 2.0 * g**2 / (cos(theta) * (z_n * cos(theta) ** 2 - 2.0 * g))

    virtual = mesh.contact_ratio / cos(mesh.beta_b) ** 2
    base, tip = m * z_n * cos(alpha), m * z_n + mesh.tip[body] - mesh.reference[body]
    along = sqrt(tip**2 - base**2) / 2.0 - pi * m * cos(alpha) * (virtual - 1.0)
    outer = 2.0 * sqrt(along**2 + (base / 2.0) ** 2)
    angle = acos(base / outer)
    half = (pi / 2.0 + 2.0 * shift * tan(alpha)) / z_n + _involute(alpha) - _involute(angle)
    load = angle - half
    arm = (cos(half) - sin(half) * tan(load)) * outer / m - z_n * cos(pi / 3.0 - theta) - (g / cos(theta) - rho)
    arm *= 0.5
    form = 6.0 * arm * cos(load) / (chord**2 * cos(alpha))
    notch, slender = chord / (2.0 * fillet), chord / arm
    correction = (1.2 + 0.13 * slender) * notch ** (1.0 / (1.21 + 2.3 / slender))
    return form * correction
