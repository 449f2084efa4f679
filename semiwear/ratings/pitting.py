"""Pitting: contact pressure against the endurance of the flank (ISO 6336-2, -5), with Miner's sum (-6)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import sqrt

import numpy as np

from semiwear.ratings.by_cycles import rated_by_cycles
from semiwear.ratings.contact import WornStep
from semiwear.ratings.life_curve import LifeCurve
from semiwear.ratings.load_factors import load_factors
from semiwear.ratings.mode import Rated
from semiwear.scene import rating_tables as tables

# Load cycles and life factors Z_NT of the groups of materials in ISO 6336-2, table 2; the scene gives the last point.
_POINTS: Mapping[str, tuple[tuple[float, float], ...]] = {
    "hardened_some_pits": ((6e5, 1.6), (1e7, 1.3), (1e9, 1.0)),
    "hardened": ((1e5, 1.6), (5e7, 1.0)),
    "nitrided": ((1e5, 1.3), (2e6, 1.0)),
    "nitrocarburized": ((1e5, 1.1), (2e6, 1.0)),
}
_END = 1e10
MOST_VISCOSITY = 500.0
"""Kinematic viscosity at which the standard's figure of Z_L ends [mm^2/s]."""

_UNITY_FACTORS: dict[str, str] = {
    "Z_H": "1: the local curvature is that of the flanks",
    "Z_E": "1: the pressure comes from both elastic bodies",
    "Z_epsilon": "1: the load sharing is solved",
    "Z_beta": "1: contact lines are those of the flanks",
    "Z_B, Z_D": "1: every roll position is rated",
}


@dataclass(frozen=True)
class PitchPoint:
    """Curvature and speed at the pitch point, for the factors of the standard.

    Attributes
    ----------
    radius : float [mm]
        Of relative curvature in the transverse section.
    speed : float [m/s]
        At the pitch line; 0 if the scene gives none.
    """

    radius: float
    speed: float


def life_points(group: str, factor_at_end: float) -> tuple[tuple[float, float], ...]:
    """Load cycles and life factors Z_NT of the corners of the life curve (ISO 6336-2:2019, table 2).

    Parameters
    ----------
    group : str
        ``"hardened"`` (St, V, GGG perlitic or bainitic, GTS, Eh, IF), ``"hardened_some_pits"`` (the same, with some
        pits permitted), ``"nitrided"`` (GG, GGG ferritic, NT, NV nitrided) or ``"nitrocarburized"``.
    factor_at_end : float
        At 1e10 cycles: 0.85, up to 1 with best lubrication, material, manufacture and experience.
    """
    return (*_POINTS[group], (_END, factor_at_end))


def _c_zl(limit: float) -> float:
    """C_ZL: 0.83 below a limit of 850 MPa, 0.91 above 1200."""
    return 0.83 + 0.08 * (min(max(limit, 850.0), 1200.0) - 850.0) / 350.0


def lubricant_factor(limit: float, viscosity_40: float) -> float:
    """Lubricant factor Z_L (ISO 6336-2:2019, 12.3.1).

    Parameters
    ----------
    limit : float [MPa]
        Allowable stress number for contact of the softer body.
    viscosity_40 : float [mm^2/s]
        Kinematic viscosity at 40 degrees Celsius; greater values count as 500.
    """
    c = _c_zl(limit)
    return c + 4.0 * (1.0 - c) / (1.2 + 134.0 / min(viscosity_40, MOST_VISCOSITY)) ** 2


def velocity_factor(limit: float, speed: float) -> float:
    """Velocity factor Z_v (ISO 6336-2:2019, 12.3.2).

    Parameters
    ----------
    limit : float [MPa]
    speed : float [m/s]
        At the pitch line.
    """
    c = _c_zl(limit) + 0.02
    return c + 2.0 * (1.0 - c) / sqrt(0.8 + 32.0 / speed)


def roughness_factor(limit: float, roughness: float, radius: float) -> float:
    """Roughness factor Z_R (ISO 6336-2:2019, 12.3.3).

    Parameters
    ----------
    limit : float [MPa]
    roughness : float [um]
        Mean Rz of both flanks.
    radius : float [mm]
        Of relative curvature at the pitch point, in the transverse section.
    """
    exponent = 0.15 - 0.07 * (min(max(limit, 850.0), 1200.0) - 850.0) / 350.0
    return float((3.0 / (roughness * (10.0 / radius) ** (1.0 / 3.0))) ** exponent)


def pitting_curve(limit: float, group: str, factor_at_end: float, influence: float, hardening: float) -> LifeCurve:
    """Permissible contact pressure over load cycles.

    The factors have their full influence from the reference number of cycles on, and none on static strength.

    Parameters
    ----------
    limit : float [MPa]
        Allowable stress number for contact, sigma_Hlim.
    group : str
        As in `life_points`.
    factor_at_end : float
    influence : float
        Z_L Z_v Z_R Z_X.
    hardening : float
        Work hardening factor Z_W, for all numbers of cycles.
    """
    return LifeCurve.of_factors(life_points(group, factor_at_end), limit * hardening, influence)


@dataclass(frozen=True)
class Pitting:
    """Safety against pitting S_H from the local pressure.

    Attributes
    ----------
    curves : (pinion, gear) of LifeCurve
    load_factor : float
        K_A K_v: factor on the load, and its square root on the pressure.
    required_safety : float
    factors : mapping
    """

    curves: tuple[LifeCurve, LifeCurve]
    load_factor: float
    required_safety: float
    factors: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, table: tables.Pitting, pitch: PitchPoint) -> Pitting:
        """The mode of a scene's table."""
        limit = min(table.pinion_limit_MPa, table.gear_limit_MPa)
        if table.film_factors == "given":
            assert table.film_factor is not None  # a rule of the scene
            film, factors = table.film_factor, {"Z_L Z_v Z_R": f"{table.film_factor:g}: given"}
        else:
            film, factors = _film(table, limit, pitch)
        influence = film * table.size_factor
        pinion = pitting_curve(
            table.pinion_limit_MPa, table.pinion_life_curve, table.life_factor_at_1e10, influence, 1.0
        )
        gear = pitting_curve(
            table.gear_limit_MPa,
            table.gear_life_curve,
            table.life_factor_at_1e10,
            influence,
            table.gear_work_hardening_factor,
        )
        factors |= {
            "Z_W": f"{table.gear_work_hardening_factor:g} of the gear: given or its default",
            "Z_X": f"{table.size_factor:g}: given or its default",
        }
        return cls(
            (pinion, gear),
            table.load_factor,
            table.required_safety,
            factors | _UNITY_FACTORS | load_factors(table),
        )

    def rate(self, steps: Sequence[WornStep]) -> Rated:
        """Safeties at every wear step."""
        pressure = np.array(
            [[contact.on_flanks(contact.pressures.inner) for contact in step.contacts] for step in steps]
        )
        return rated_by_cycles(steps, sqrt(self.load_factor) * pressure, self.curves, self.required_safety)


def _film(table: tables.Pitting, limit: float, pitch: PitchPoint) -> tuple[float, dict[str, str]]:
    """Z_L Z_v Z_R, and each factor with its reason; rules of the scene ensure that the oil is given."""
    viscosity, roughness = table.viscosity_40_mm2_per_s, table.roughness_Rz_um
    assert viscosity is not None and roughness is not None
    z_l, z_v = lubricant_factor(limit, viscosity), velocity_factor(limit, pitch.speed)
    z_r = roughness_factor(limit, roughness, pitch.radius)
    counted = f", of which {MOST_VISCOSITY:g} count" if viscosity > MOST_VISCOSITY else ""
    factors = {
        "Z_L": f"{z_l:.4g}: {viscosity:g} mm2/s at 40 degrees Celsius{counted}",
        "Z_v": f"{z_v:.4g}: {pitch.speed:.4g} m/s at the pitch line",
        "Z_R": f"{z_r:.4g}: Rz {roughness:g} um, radius of relative curvature {pitch.radius:.4g} mm",
    }
    return z_l * z_v * z_r, factors
