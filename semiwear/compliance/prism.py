"""Finite prisms: a tooth body of constant section as plane finite elements times cosines along its width.

A body of width L (coordinate z in [0, L]) has one plane section, several teeth on their rim. With k = n pi/L

    u = sum_n U_n(x, y) cos(k z),   v = sum_n V_n cos(k z),   w = sum_n W_n sin(k z)

so that strains are a cosine (or sine) times (B0 + k B1) q and the harmonics decouple:

    K_n = K0 + k K1 + k^2 K2,   K0 = int B0' D B0,   K1 = int (B0' D B1 + B1' D B0),   K2 = int B1' D B1

A point load P at z0 moves the section at z by  sum_n (c_n/L) cos(k z) cos(k z0) K_n^-1 P,  c_0 = 1, c_n = 2.
The cosines mirror the body at its ends: shear stress and axial displacement vanish there; `tooth_ends` corrects that
to a free end. Harmonics are solved on one pitch (`condensed_pitch`); `pitch_chain` joins the pitches.

Source: Y. K. Cheung, Finite Strip Method in Structural Analysis, Pergamon 1976, ch. 6 (finite prisms);
O. C. Zienkiewicz, R. L. Taylor, The Finite Element Method, vol. 2, 5th ed. 2000, ch. 9 (semi-analytical).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil, log

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.sparse import csr_matrix, vstack

from semiwear.arrays import FloatArray, IntArray
from semiwear.compliance.condensed_pitch import Pitch, PitchRows
from semiwear.compliance.pitch_chain import join
from semiwear.compliance.section_elements import (
    fillet_edges,
    fillet_shares,
    harmonic_integrals,
    mid_surface,
    node_rows,
)
from semiwear.compliance.section_mesh import SectionMesh, SectionMeshError, elements_at_root, section_mesh
from semiwear.geometry.section import RingRim, ToothSection
from semiwear.kept_on_disk import kept_on_disk


@dataclass(frozen=True)
class PrismSection:
    """Influence of unit loads on the flank of one tooth, harmonic by harmonic along the width.

    A load P at height j and width coordinate z0, along the inward normal of the flank, gives at z

        deflection  P sum_n cos(n pi z/L) cos(n pi z0/L) deflection[n, offset, i, j]   [mm]
        stress      P sum_n cos(n pi z/L) cos(n pi z0/L) stress[n, offset, f, j]       [MPa]

    (the factors 1/L, 2/L are in the arrays).

    Attributes
    ----------
    width : float
        Width L of the prism [mm].
    load_profile : (H,) array
        Profile coordinate of the load heights, from the lower end of the flank to the tip.
    depth : (H,) array [mm]
        Distance from the flank to its mid-surface point, along the inward normal.
    deflection : (N, 5, H, H) array [mm/N]
        Displacement of the mid-surface point of height i of the tooth at an offset of `DEFLECTION_OFFSETS`,
        along the inward normal at i, for a unit load at height j of the middle tooth. Made reciprocal:
        ``deflection[:, 2 + o] == deflection[:, 2 - o]`` transposed.
    stress : (N, 3, F, H) array [MPa/N]
        Tangential stress at the points of the fillet on the loaded side (x > 0) of the tooth at an offset of
        `STRESS_OFFSETS`, tensile positive.
    fillet_points : (F, 2) array [mm]
        Points of the stress, from the end of the flank to the root.
    fillet_share : (F,) array
        The same points as length from the end of the flank over the fillet's.
    asymmetry : float
        Greatest change of the deflection by symmetrisation, relative to the greatest at n = 0.
    """

    width: float
    load_profile: FloatArray
    depth: FloatArray
    deflection: FloatArray
    stress: FloatArray
    fillet_points: FloatArray
    fillet_share: FloatArray
    asymmetry: float


@kept_on_disk
def prism_section(
    section: ToothSection,
    *,
    width: float,
    youngs_modulus: float,
    poissons_ratio: float,
    harmonics: int = 33,
    heights: int = 12,
    rack_teeth: int = 21,
    solve_every: bool = False,
    fillet_elements: int | None = None,
    elements_across: int | None = None,
    elements_below: int | None = None,
    name: str = "tooth section",
) -> PrismSection:
    """Influence of flank loads on mid-surface deflection and fillet stress of a prismatic tooth body.

    Parameters
    ----------
    section : ToothSection
        Half outline of a tooth and its rim [mm].
    width : float
        Width L of the prism [mm].
    youngs_modulus : float
        Young's modulus [MPa].
    poissons_ratio : float
        Poisson's ratio, below 0.5.
    harmonics : int
        Number N of cosines, n = 0 ... N - 1. The shortest wave, 2 L/(N - 1), should be at most about a third
        of the tooth height.
    heights : int
        Number H of load heights.
    rack_teeth : int
        Teeth of a rack, an odd number; its ends are free. Influence on teeth beyond them is zero. A ring is
        always whole.
    solve_every : bool
        Solve every harmonic instead of about fourteen with a spline between them.
    fillet_elements, elements_across, elements_below, name
        See `section_mesh`; by default 3 elements below a tooth, and more on a ring whose bore is small; 8 along the
        fillet and 5 across the tooth, and more where the fillet is sharp or the rim thin (`elements_at_root`). With
        these the greatest fillet stress is within 1 % of the converged
        section's with the usual fillets, within 3 % where the tool is not rounded. With six along the fillet, a load
        within half a millimetre of its upper end causes a spurious stress below it, half as high as the true peak.

    Returns
    -------
    PrismSection

    Raises
    ------
    SectionMeshError
        If the section cannot be meshed, or a ring has fewer than 6 teeth.
    ValueError
        If a number is out of its range.

    Notes
    -----
    Three limits. Loads act at points of the section, so that stress within about 2 mm of a load depends on the
    mesh; the lowest height is the end of the fillet itself, and the stress of a much shorter fillet under a load
    there is not that of a real contact. Stress grows without limit as a fillet's radius goes to zero: it is resolved
    down to a thousandth of the way across, and a sharp corner is refused. And waves shorter than 2 L/(N - 1) are
    missing: where the mid-surface lies closer to the load than half of that (thin tips), its deflection under a point
    load is too small, but not under a load spread over such a length.
    """
    _check_numbers(width, youngs_modulus, poissons_ratio, harmonics, rack_teeth)
    if isinstance(section.rim, RingRim) and section.rim.teeth < 6:
        raise SectionMeshError(f"{name}: a ring needs 6 teeth at least, not {section.rim.teeth}")
    at_root = elements_at_root(section)
    mesh = section_mesh(
        section,
        heights=heights,
        fillet_elements=at_root.along if fillet_elements is None else fillet_elements,
        elements_across=at_root.across if elements_across is None else elements_across,
        towards_surface=at_root.growth,
        elements_below=_elements_below(section) if elements_below is None else elements_below,
        name=name,
    )
    observer = _Observer.of(mesh, youngs_modulus, poissons_ratio)
    half = replace(mesh, elements=mesh.elements[: len(mesh.elements) // 2])
    k0, mixed, k2 = harmonic_integrals(half, youngs_modulus, poissons_ratio)
    pitch = Pitch.of(half, section, (k0, mixed + mixed.T, k2), observer.rows)

    solved = np.arange(harmonics) if solve_every else _solved_harmonics(harmonics)
    wave_number = np.asarray(np.arange(harmonics) * np.pi / width, dtype=np.float64)
    deflection, stress = join(pitch.condense(wave_number[solved]), section, rack_teeth)

    weight = np.where(np.arange(harmonics) == 0, 1.0, 2.0)[:, None, None, None] / width
    tooth_height = mesh.nodes[mesh.centre_line[0], 1] - mesh.nodes[mesh.fillet[-1], 1]
    variable = np.arcsinh(4 * tooth_height * wave_number)
    deflection = weight * _between_harmonics(variable[solved], deflection, variable)
    stress = weight * _between_harmonics(variable[solved], stress, variable)
    reciprocal = (deflection + deflection[:, ::-1].swapaxes(2, 3)) / 2
    asymmetry = np.abs(reciprocal - deflection).max() / np.abs(deflection[0]).max()
    return PrismSection(
        width=float(width),
        load_profile=mesh.load_profile,
        depth=observer.depth,
        deflection=reciprocal,
        stress=stress,
        fillet_points=observer.fillet_points,
        fillet_share=fillet_shares(mesh),
        asymmetry=float(asymmetry),
    )


@dataclass(frozen=True)
class _Observer:
    """Loads and observed quantities of one tooth as sparse rows on its degrees of freedom."""

    load: csr_matrix  # (H, 3 n): unit loads on the flank
    deflection: csr_matrix  # (H, 3 n)
    stress: csr_matrix  # (F, 3 n): part by strains in the section, and ...
    stress_along: csr_matrix  # ... part to be multiplied by k
    depth: FloatArray
    fillet_points: FloatArray

    @classmethod
    def of(cls, mesh: SectionMesh, youngs_modulus: float, poissons_ratio: float) -> _Observer:
        plane_stress = youngs_modulus / (1 - poissons_ratio**2)
        load = node_rows(mesh, mesh.flank[:, None], mesh.flank_normal[:, None])
        nodes, weights, middle = mid_surface(mesh)
        deflection = node_rows(mesh, nodes, weights[:, :, None] * mesh.flank_normal[:, None])
        nodes, slopes, values, tangent, points = fillet_edges(mesh)
        stress = plane_stress * node_rows(mesh, nodes, slopes[:, :, None] * tangent[:, None])
        stretch = values[:, :, None] * np.array([0.0, 0.0, 1.0])
        stress_along = plane_stress * poissons_ratio * node_rows(mesh, nodes, stretch)
        depth = np.linalg.norm(middle - mesh.nodes[mesh.flank], axis=1)
        return cls(load, deflection, stress, stress_along, depth, points)

    @property
    def rows(self) -> PitchRows:
        """Loads and readings (deflection; stress) of a pitch."""
        heights, gauges = self.load.shape[0], self.stress.shape[0]
        steady = csr_matrix(self.load.shape)
        return PitchRows(
            fixed=vstack([self.load, self.deflection, self.stress]).tocsr(),
            along=vstack([steady, steady, self.stress_along]).tocsr(),
            load=slice(0, heights),
            deflection=slice(heights, 2 * heights),
            stress=slice(2 * heights, 2 * heights + gauges),
        )


def _solved_harmonics(harmonics: int) -> IntArray:
    """Harmonics to solve: 0 to 6, then each a quarter higher, 8, 10, 12, 16 ..., and the last."""
    solved = [0]
    while solved[-1] < harmonics - 1:
        solved.append(min(max(solved[-1] + 1, round(1.25 * solved[-1])), harmonics - 1))
    return np.array(solved)


def _elements_below(section: ToothSection) -> int:
    """Elements from a tooth down to the held face: towards a small bore strains grow as 1/r^2."""
    if not isinstance(section.rim, RingRim) or section.rim.bore_radius <= 0.0:
        return 3  # a ring without a bore is refused when it is meshed
    ratio = float(np.hypot(*section.fillet[-1])) / section.rim.bore_radius
    return 3 + max(0, ceil(6.0 * log(ratio / 2.5)))


def _between_harmonics(solved: FloatArray, values: FloatArray, harmonics: FloatArray) -> FloatArray:
    """Quintic spline through the solved harmonics and their mirror images: influence is even in k."""
    if len(solved) == len(harmonics):
        return values
    mirrored = np.concatenate([-solved[:0:-1], solved])
    return np.asarray(make_interp_spline(mirrored, np.concatenate([values[:0:-1], values]), k=5)(harmonics))


def _check_numbers(
    width: float, youngs_modulus: float, poissons_ratio: float, harmonics: int, rack_teeth: int
) -> None:
    if not (width > 0 and youngs_modulus > 0):
        raise ValueError(f"width and Young's modulus must be positive, not {width} and {youngs_modulus}")
    if not -1 < poissons_ratio < 0.5:
        raise ValueError(f"Poisson's ratio must lie between -1 and 0.5, not {poissons_ratio}")
    if harmonics < 1:
        raise ValueError(f"harmonics must be 1 at least, not {harmonics}")
    if rack_teeth < 1 or rack_teeth % 2 == 0:
        raise ValueError(f"rack_teeth must be odd and positive, not {rack_teeth}")
