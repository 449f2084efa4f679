"""Tooth root breakage: root stress against the strength of the root (ISO 6336-3, -5), with Miner's sum (-6)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import sqrt

import numpy as np

from semiwear.ratings.by_cycles import rated_by_cycles
from semiwear.ratings.contact import RatedContact, WornStep
from semiwear.ratings.life_curve import LifeCurve
from semiwear.ratings.load_factors import load_factors
from semiwear.ratings.mode import Rated
from semiwear.scene import rating_tables as tables

# Load cycles and life factors Y_NT of the groups of materials in ISO 6336-3, table 3; the scene gives the last point.
_POINTS: Mapping[str, tuple[tuple[float, float], ...]] = {
    "normalized": ((1e4, 2.5), (3e6, 1.0)),
    "through_hardened": ((1e4, 2.5), (3e6, 1.0)),
    "case_hardened": ((1e3, 2.5), (3e6, 1.0)),
    "cast_iron": ((1e3, 1.6), (3e6, 1.0)),
    "nitrided": ((1e3, 1.6), (3e6, 1.0)),
    "nitrocarburized": ((1e3, 1.1), (3e6, 1.0)),
}
_END = 1e10
_STRESS_CORRECTION = 2.0  # Y_ST of the test gears for sigma_Flim

_UNITY_FACTORS: dict[str, str] = {
    "Y_F, Y_S": "1: the root stress is that of the fillet itself, with its notch effect",
    "Y_epsilon, Y_DT": "1: the load sharing is solved, and every roll position is rated",
    "Y_beta": "1: the tooth is solved under its oblique contact lines",
    "Y_B": "1: the rim is part of the tooth's compliance",
}


def life_points(group: str, factor_at_end: float) -> tuple[tuple[float, float], ...]:
    """Load cycles and life factors Y_NT of the corners of the life curve (ISO 6336-3:2019, table 3).

    Parameters
    ----------
    group : str
        ``"normalized"`` (St: normalized steel of low carbon, cast steel), ``"through_hardened"`` (V, GGG perlitic or
        bainitic, GTS), ``"case_hardened"`` (Eh, IF with a hardened root), ``"cast_iron"`` (GG, GGG ferritic),
        ``"nitrided"`` (NT, NV nitrided) or ``"nitrocarburized"``.
    factor_at_end : float
        At 1e10 cycles: 0.85, up to 1.
    """
    return (*_POINTS[group], (_END, factor_at_end))


def relative_surface_factor(group: str, roughness: float) -> float:
    """Relative surface factor Y_R_relT (ISO 6336-3:2019, 14.3).

    Parameters
    ----------
    group : str
        As in `life_points`.
    roughness : float [um]
        Rz of the fillet; values below 1 um count as 1 um.
    """
    rz = max(roughness, 1.0)
    if group == "normalized":
        return float(5.306 - 4.203 * (rz + 1.0) ** (1.0 / 100.0))
    if group in ("cast_iron", "nitrided", "nitrocarburized"):
        return float(4.299 - 3.259 * (rz + 1.0) ** (1.0 / 200.0))
    return float(1.674 - 0.529 * (rz + 1.0) ** (1.0 / 10.0))


def relative_notch_sensitivity_factor(notch_parameter: float, slip_layer: float) -> float:
    """Relative notch sensitivity factor Y_delta_relT at the reference stress (ISO 6336-3:2019, 13.3).

    Parameters
    ----------
    notch_parameter : float
        q_s: root thickness at the critical section over twice the fillet's radius there.
    slip_layer : float [mm]
        rho': 0.0030 of case-hardened steel, 0.1005 nitrided, 0.0833 to 0.0014 of steel by its yield strength.
    """
    gradient, test_gradient = (0.2 * (1.0 + 2.0 * q) for q in (notch_parameter, 2.5))
    return (1.0 + sqrt(slip_layer * gradient)) / (1.0 + sqrt(slip_layer * test_gradient))


def size_factor(group: str, module: float) -> float:
    """Size factor Y_X (ISO 6336-3:2019, table 4).

    Parameters
    ----------
    group : str
        As in `life_points`.
    module : float [mm]
        Normal module.
    """
    if group == "cast_iron":
        return min(1.0, max(0.70, 1.075 - 0.015 * module))
    if group in ("normalized", "through_hardened"):
        return min(1.0, max(0.85, 1.03 - 0.006 * module))
    return min(1.0, max(0.80, 1.05 - 0.01 * module))


def bending_curve(
    limit: float, group: str, factor_at_end: float, notch: float, surface_and_size: float, mean_stress: float
) -> LifeCurve:
    """Permissible root stress over load cycles.

    Notch sensitivity, surface and size have their full influence from the reference number of cycles on, and none on
    static strength.

    Parameters
    ----------
    limit : float [MPa]
        Nominal stress number for bending, sigma_Flim.
    group : str
        As in `life_points`.
    factor_at_end : float
    notch : float
        Y_delta_relT.
    surface_and_size : float
        Y_R_relT Y_X.
    mean_stress : float
        Y_M, for all numbers of cycles.
    """
    stress = limit * _STRESS_CORRECTION * mean_stress
    return LifeCurve.of_factors(life_points(group, factor_at_end), stress, notch * surface_and_size)


@dataclass(frozen=True)
class Bending:
    """Safety against tooth breakage S_F from the local root stress.

    The safety at a point of the flank is that of the tooth root while the contact passes this point.

    Attributes
    ----------
    curves : (pinion, gear) of LifeCurve
    load_factor : float
        K_A K_v.
    required_safety : float
    factors : mapping
    """

    curves: tuple[LifeCurve, LifeCurve]
    load_factor: float
    required_safety: float
    factors: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, table: tables.Bending, module: float) -> Bending:
        """The mode of a scene's table; `module` is the normal module [mm]."""
        bodies = (
            ("pinion", table.pinion_limit_MPa, table.pinion_life_curve),
            ("gear", table.gear_limit_MPa, table.gear_life_curve),
        )
        curves, factors = [], {}
        for body, limit, group in bodies:
            surface = relative_surface_factor(group, table.root_roughness_Rz_um)
            size = size_factor(group, module) if table.size_factor is None else table.size_factor
            curves.append(
                bending_curve(
                    limit,
                    group,
                    table.life_factor_at_1e10,
                    table.notch_sensitivity_factor,
                    surface * size,
                    table.mean_stress_factor,
                )
            )
            factors[f"Y_R_relT of the {body}"] = f"{surface:.4g}: Rz {table.root_roughness_Rz_um:g} um"
            how = "given" if table.size_factor is not None else f"module {module:.4g} mm"
            factors[f"Y_X of the {body}"] = f"{size:.4g}: {how}"
        factors |= {
            "Y_delta_relT": f"{table.notch_sensitivity_factor:g}: given or its default",
            "Y_M": f"{table.mean_stress_factor:g}: given or its default",
        }
        return cls(
            (curves[0], curves[1]),
            table.load_factor,
            table.required_safety,
            factors | _UNITY_FACTORS | load_factors(table),
        )

    def rate(self, steps: Sequence[WornStep]) -> Rated:
        """Safeties at every wear step."""
        stress = np.array([[_root_stress_on_flanks(contact) for contact in step.contacts] for step in steps])
        return rated_by_cycles(steps, self.load_factor * stress, self.curves, self.required_safety)


def _root_stress_on_flanks(contact: RatedContact) -> np.ndarray:
    """Root stress while the load is at each node, (body, face, node) [MPa], loads at edges included."""
    return contact.on_flanks(contact.root_stress[..., None], contact.state.loads.force > 0.0)
