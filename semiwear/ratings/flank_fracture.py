"""Tooth flank fracture: shear below the flank against the strength of case and core at that depth.

The local method of Hertter (2003) and Witzig (2012), dissertations, TU Munich, from which ISO/TS 6336-4:2019 took its
fits: at every depth the shear stress intensity of Hertz and residual stress together, less that of the residual
stress alone, over a strength of 0.4 MPa for each HV. The standard uses a fit for the influence of the residual
stress; here the stress tensors are added. Neither text was at hand: 0.4 and 0.04 are confirmed by a report of a
commercial program on ISO DTR 19042-1, the limit 0.8 is as commonly quoted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import sqrt

import numpy as np
from numpy.typing import ArrayLike

from semiwear.arrays import FloatArray
from semiwear.contact.worn_depth import worn_depth
from semiwear.meshing.flank_pair import BODIES, DRIVEN
from semiwear.ratings.contact import RatedContact, WornStep
from semiwear.ratings.hardness import HardnessProfile, hardness_of_case, hardness_of_table, residual_stress
from semiwear.ratings.load_factors import load_factors
from semiwear.ratings.mode import Rated, rated_locally
from semiwear.ratings.overload import raised
from semiwear.scene import flank_fracture_table as tables

FLANK_FRACTURE_SOURCE = (
    "after Hertter 2003 and Witzig 2012 (shear stress intensity, 0.4 MPa/HV), constants as commonly quoted;"
    " not a rating to ISO/TS 6336-4:2019, which fits the same"
)

_STRENGTH_MPA_PER_HV = 0.4  # K_tau,per
_EXPOSURE_OFFSET = 0.04  # c_1
_LIMIT = 0.8  # exposure of gears that did not fail
_DEEPEST = 12.0  # half-widths: there the shear stress is less than a tenth of its maximum
_DEPTHS = 40


@dataclass(frozen=True)
class FlankMaterial:
    """Strength of a flank below its surface.

    Attributes
    ----------
    hardness : callable
        HV over depth in mm (`semiwear.ratings.hardness`).
    core : float [HV]
    factor : float
        K_material: 1 for CrNiMo case-hardening steels.
    poissons_ratio : float
    """

    hardness: HardnessProfile
    core: float
    factor: float = 1.0
    poissons_ratio: float = 0.3


def line_contact_stress(pressure: ArrayLike, depth: ArrayLike, poissons_ratio: float = 0.3) -> FloatArray:
    """Principal stresses below the middle of a frictionless line contact (Johnson 1985, eqs. 4.46, plane strain).

    Parameters
    ----------
    pressure : array [MPa]
        Greatest Hertz pressure p0.
    depth : array
        Depth over half-width, z/b.
    poissons_ratio : float

    Returns
    -------
    (3, ...) array [MPa]
        Across the line, along it and normal to the surface; tension is positive.
    """
    pressure, depth = np.broadcast_arrays(np.asarray(pressure, float), np.asarray(depth, float))
    root = np.sqrt(1.0 + depth**2)
    # (1 + 2 z^2)/root - 2 z, rewritten without cancellation at great depths
    across = -pressure / (root * (root + depth) ** 2)
    normal = -pressure / root
    return np.stack([across, poissons_ratio * (across + normal), normal])


def shear_stress_intensity(stress: ArrayLike) -> FloatArray:
    """Root mean square of the shear stress over all planes, sqrt(2/15) of the von Mises stress [MPa].

    tau_eff = sqrt(1/(4 pi) * integral of tau^2 over all directions of the plane's normal) (Novozhilov 1952).

    Parameters
    ----------
    stress : (3, ...) array [MPa]
        Principal stresses.
    """
    first, second, third = np.asarray(stress, float)
    squares = (first - second) ** 2 + (second - third) ** 2 + (third - first) ** 2
    return np.asarray(np.sqrt(squares / 15.0))


def material_exposure(
    pressure: ArrayLike, half_width: ArrayLike, material: FlankMaterial, worn: ArrayLike = 0.0
) -> tuple[FloatArray, FloatArray]:
    """Greatest material exposure A_FF below a flank, and its depth.

    A_FF(y) = (tau_eff(load + residual) - tau_eff(residual))/(0.4 K_material HV(y)) + 0.04, at depths from one
    half-width of the contact on; nearer to the surface the failure is pitting. Up to 0.8 counts as safe (Witzig
    2012).

    Parameters
    ----------
    pressure : array [MPa]
        Greatest Hertz pressure.
    half_width : array [mm]
    material : FlankMaterial
    worn : array [mm]
        Wear depth, by which the case is thinner.

    Returns
    -------
    exposure : array
        Of the shape of the pressure; 0 without pressure.
    depth : array [mm]
        Below the worn flank, from 40 depths between one and twelve half-widths with a parabola through the greatest.
    """
    pressure, half_width = np.broadcast_arrays(np.asarray(pressure, float), np.asarray(half_width, float))
    loaded = pressure > 0.0
    width = np.where(loaded, half_width, 1.0)
    scale = np.geomspace(1.0, _DEEPEST, _DEPTHS).reshape(-1, *(1,) * pressure.ndim)
    exposure = _exposure(pressure, scale, width, material, np.asarray(worn, float))
    best, log_scale = _peak(exposure, np.log(scale).ravel())
    depth = np.exp(log_scale) * width
    return np.where(loaded, best, 0.0), np.where(loaded, depth, 0.0)


def flank_fracture_safety(exposure: ArrayLike) -> FloatArray:
    """Safety S_FF = 0.8/A_FF against flank fracture; infinite without load (exposure 0)."""
    exposure = np.asarray(exposure, float)
    return np.where(exposure > 0.0, _LIMIT / np.where(exposure > 0.0, exposure, 1.0), np.inf)


def _exposure(
    pressure: FloatArray, scale: FloatArray, width: FloatArray, material: FlankMaterial, worn: FloatArray
) -> FloatArray:
    load = line_contact_stress(pressure, scale, material.poissons_ratio)
    hardness = material.hardness(worn + scale * width)
    residual = residual_stress(hardness, material.core)
    total = load.copy()
    total[:2] += residual
    shear = shear_stress_intensity(total) - sqrt(2.0 / 15.0) * np.abs(residual)
    strength = _STRENGTH_MPA_PER_HV * material.factor * hardness
    return np.asarray(np.maximum(shear, 0.0) / strength + _EXPOSURE_OFFSET)


def _peak(values: FloatArray, abscissa: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Maximum along the first axis and its abscissa, by a parabola through three equidistant points."""
    top = values.argmax(axis=0)
    inner = np.clip(top, 1, values.shape[0] - 2)
    before, at, after = (np.take_along_axis(values, (inner + k)[None], axis=0)[0] for k in (-1, 0, 1))
    bend = before - 2.0 * at + after
    shift = np.where(bend < 0.0, 0.5 * (before - after) / np.where(bend < 0.0, bend, 1.0), 0.0)
    shift = np.where((top == inner) & (np.abs(shift) <= 1.0), shift, 0.0)
    at_end = np.take_along_axis(values, top[None], axis=0)[0]
    best = np.where(top == inner, at - 0.25 * (before - after) * shift, at_end)
    step = abscissa[1] - abscissa[0]
    return best, abscissa[top] + shift * step


@dataclass(frozen=True)
class FlankFracture:
    """Safety against flank fracture of both flanks in every slice, with the case thinned by wear.

    Attributes
    ----------
    materials : (pinion, gear) of FlankMaterial
    load_factor : float
        K_A K_v.
    required_safety : float
    factors : mapping
    """

    materials: tuple[FlankMaterial, FlankMaterial]
    load_factor: float
    required_safety: float
    factors: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, table: tables.FlankFracture, poissons_ratios: tuple[float, float]) -> FlankFracture:
        """The mode of a scene's table."""
        pinion, gear = (
            FlankMaterial(
                _hardness(table, body), getattr(table, f"{body}_core_hardness_HV"), table.material_factor, ratio
            )
            for body, ratio in zip(BODIES, poissons_ratios, strict=True)
        )
        factors = {
            "K_tau,per": f"{_STRENGTH_MPA_PER_HV:g} MPa/HV: shear strength of steel over hardness",
            "K_material": f"{table.material_factor:g}: given",
            "HV(y)": "measured"
            if table.hardness_profile == "table"
            else "from surface, core and case depth (Lang 1979)",
            "sigma_RS(y)": "from the hardness (Lang 1979), no tension in the core",
            "source": FLANK_FRACTURE_SOURCE,
        }
        return cls(
            (pinion, gear),
            table.load_factor,
            table.required_safety,
            factors | load_factors(table),
        )

    def rate(self, steps: Sequence[WornStep]) -> Rated:
        """Safeties at every wear step."""
        return rated_locally(steps, self._safety)

    def _safety(self, contact: RatedContact) -> FloatArray:
        conditions, rated = raised(contact.conditions, self.load_factor), contact.rated
        pressure, half_width = conditions.pressure[rated], conditions.half_width[rated]
        safety = np.full((len(self.materials), *rated.shape), np.nan)
        depths = worn_depth(contact.teeth, contact.state, contact.places[DRIVEN])
        for body_safety, material, worn in zip(safety, self.materials, depths, strict=True):
            exposure, _ = material_exposure(pressure, half_width, material, worn[rated])
            body_safety[rated] = flank_fracture_safety(exposure)
        return safety


def _hardness(table: tables.FlankFracture, body: str) -> HardnessProfile:
    """Hardness of a body over depth; rules of the scene ensure that it is given."""
    if table.hardness_profile == "table":
        return hardness_of_table(getattr(table, f"{body}_hardness_depths_mm"), getattr(table, f"{body}_hardness_HV"))
    names = ("surface_hardness_HV", "core_hardness_HV", "case_depth_mm")
    return hardness_of_case(*(getattr(table, f"{body}_{name}") for name in names))
