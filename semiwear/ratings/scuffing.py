"""Scuffing: contact temperature against the scuffing temperature of the oil's test gears.

Flash temperature method (ISO/TR 13989-1:2000, now ISO/TS 6336-20) and integral temperature method (ISO/TR
13989-2:2000, now ISO/TS 6336-21), with the flash temperature of every slice in place of the standards' factors for
load sharing, geometry and contact ratio. Their texts were not at hand: the formulas are as quoted by the open program
Mekanika (mekanika.org, 2026).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from semiwear.arrays import FloatArray
from semiwear.contact.flash_temperature import FlashTemperature
from semiwear.contact.friction import Friction
from semiwear.ratings.contact import RatedContact, WornStep
from semiwear.ratings.heated_contact import FrictionalHeat
from semiwear.ratings.load_factors import load_factors
from semiwear.ratings.mode import Rated, rated_locally
from semiwear.ratings.oil import LUBRICANT_FACTOR, Oil
from semiwear.scene import oil_rating_tables as tables

Lubrication = Literal["spray", "dip", "submerged"]

SCUFFING_SOURCE = "ISO/TR 13989-1 and -2:2000 (ISO/TS 6336-20 and -21), formulas as an open program quotes them"

_LUBRICATION_FACTOR: dict[Lubrication, float] = {"spray": 1.2, "dip": 1.0, "submerged": 0.2}  # X_S
_WEIGHT = 1.5  # C_2: of the mean flash temperature in the integral temperature
_TEST_TORQUE = 3.726  # N m over the square of the load stage, pinion of the test gears A/8,3/90


def scuffing_temperature(oil: Oil, oil_temperature: float, load_stage: float, structure: float = 1.0) -> float:
    """Scuffing temperature theta_S = 80 + (0.85 + 1.4 X_W) X_L S_FZG^2 of an oil [degC].

    ISO/TR 13989-1:2000, eqs. 27 and 99, with X_L = X eta^-0.05 and X = 1 for mineral oil.

    Parameters
    ----------
    oil : Oil
    oil_temperature : float [degC]
    load_stage : float
        Failure load stage of the FZG test A/8,3/90 (ISO 14635-1), not of its other variants.
    structure : float
        X_W: 1 for case-hardened steel of normal austenite content, 1.15 for low and 0.85 for high content,
        1.25 phosphated, 1.5 copper-plated or nitrided, 0.45 for stainless steel.
    """
    lubricant = LUBRICANT_FACTOR[oil.family] * float(oil.dynamic_viscosity(oil_temperature) ** -0.05)
    return 80.0 + (0.85 + 1.4 * structure) * lubricant * load_stage**2


def scuffing_integral_temperature(oil: Oil, load_stage: float, structure: float = 1.0) -> float:
    """Scuffing integral temperature theta_intS of an oil [degC].

    80 + X_L T (0.23 + 1.5 X_W 0.2 (100/nu_40)^0.02) with the pinion's torque T = 3.726 S_FZG^2 in N m
    (ISO/TR 13989-2:2000, eqs. 94 to 97); parameters as in `scuffing_temperature`.
    """
    heat = LUBRICANT_FACTOR[oil.family] * _TEST_TORQUE * load_stage**2
    return 80.0 + heat * (0.23 + _WEIGHT * structure * 0.2 * float((100.0 / oil.viscosity_40) ** 0.02))


def mean_flash_temperature(flash: ArrayLike, roll: ArrayLike) -> FloatArray:
    """Mean of the flash temperature along the path of contact [K], over the first axis.

    Parameters
    ----------
    flash : (roll, ...) array [K]
        0 where a slice bears no load.
    roll : (roll,) array
        Roll positions, in any unit proportional to the distance along the path.

    Returns
    -------
    (...) array
        Mean of each slice over the roll positions at which it bears load; 0 if there are none.
    """
    flash = np.asarray(flash, float)
    weight = np.gradient(np.asarray(roll, float)).reshape(-1, *(1,) * (flash.ndim - 1)) * (flash > 0.0)
    return np.asarray((flash * weight).sum(axis=0) / np.maximum(weight.sum(axis=0), np.finfo(float).tiny))


def bulk_temperature_flash(oil_temperature: float, mean_flash: ArrayLike, lubrication: Lubrication) -> FloatArray:
    """Bulk temperature theta_M = theta_oil + 0.47 X_S theta_flm [degC] of the flash temperature method.

    ISO/TR 13989-1:2000, eq. 22, for one mating gear.
    """
    return np.asarray(oil_temperature + 0.47 * _LUBRICATION_FACTOR[lubrication] * np.asarray(mean_flash, float))


def bulk_temperature_integral(oil_temperature: float, mean_flash: ArrayLike, lubrication: Lubrication) -> FloatArray:
    """Bulk temperature theta_M = theta_oil + 0.7 X_S theta_flaint [degC] of the integral temperature method.

    ISO/TR 13989-2:2000, eq. 20, for one mating gear.
    """
    return np.asarray(oil_temperature + 0.7 * _LUBRICATION_FACTOR[lubrication] * np.asarray(mean_flash, float))


def flash_temperature_safety(contact: ArrayLike, limit: float, oil_temperature: float) -> FloatArray:
    """Safety S_B = (theta_S - theta_oil)/(theta_B - theta_oil) against scuffing, infinite at the oil temperature.

    A quotient of temperature differences (ISO/TR 13989-1:2000, eq. 100): it falls more slowly than the load grows.

    Parameters
    ----------
    contact : array [degC]
        Contact temperature, bulk and flash together.
    limit : float [degC]
        `scuffing_temperature`.
    oil_temperature : float [degC]
    """
    rise = np.asarray(contact, float) - oil_temperature
    return np.where(rise > 0.0, (limit - oil_temperature) / np.where(rise > 0.0, rise, 1.0), np.inf)


def integral_temperature_safety(bulk: ArrayLike, mean_flash: ArrayLike, limit: float) -> FloatArray:
    """Safety S_intS = theta_intS/(theta_M + 1.5 theta_flaint) against scuffing (ISO/TR 13989-2:2000, eqs. 14, 17).

    A quotient of temperatures in degrees Celsius: below 1 scuffing is likely, above 2 it is not. Infinite where the
    integral temperature is 0 degC or less, for which the quotient has no meaning.

    Parameters
    ----------
    bulk : array [degC]
    mean_flash : array [K]
    limit : float [degC]
        `scuffing_integral_temperature`.
    """
    integral = np.asarray(bulk, float) + _WEIGHT * np.asarray(mean_flash, float)
    return np.where(integral > 0.0, limit / np.where(integral > 0.0, integral, 1.0), np.inf)


@dataclass(frozen=True)
class Scuffing:
    """Safety against scuffing by either method, from the flash temperature in every slice.

    The bulk temperature of every station follows from the flash temperature there. Heat conduction along the teeth is
    neglected, as in the standards, which use the load of the worst station.

    Attributes
    ----------
    heat : FrictionalHeat
    method : {"flash_temperature", "integral_temperature"}
    limit : float [degC]
        Scuffing temperature of the method.
    oil_temperature : float [degC]
    lubrication : {"spray", "dip", "submerged"}
    required_safety : float
    factors : mapping
    """

    heat: FrictionalHeat
    method: Literal["flash_temperature", "integral_temperature"]
    limit: float
    oil_temperature: float
    lubrication: Lubrication
    required_safety: float
    factors: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, table: tables.Scuffing, flash: FlashTemperature, friction: Friction) -> Scuffing:
        """The mode of a scene's table."""
        oil = Oil.of(table)
        if table.method == "integral_temperature":
            limit = scuffing_integral_temperature(oil, table.load_stage, table.structural_factor)
            symbol = "theta_intS"
        else:
            limit = scuffing_temperature(oil, table.oil_temperature_C, table.load_stage, table.structural_factor)
            symbol = "theta_S"
        lubrication: Lubrication = table.oil_supply  # type: ignore[assignment]
        factors = {
            symbol: f"{limit:.4g} degrees Celsius: failure load stage {table.load_stage:g} of A/8,3/90",
            "theta_oil": f"{table.oil_temperature_C:g} degrees Celsius: given",
            "X_W": f"{table.structural_factor:g}: given",
            "X_S": f"{_LUBRICATION_FACTOR[lubrication]:g}: {table.oil_supply}",
            "X_Gamma, X_G, X_BE, X_epsilon": "1: load, motion and curvature are those of every slice",
            "X_J, X_Q, X_Ca": "1: loads at the start of contact are solved, with tip relief",
            "source": SCUFFING_SOURCE,
        }
        return cls(
            FrictionalHeat(flash, friction, table.load_factor),
            table.method,  # type: ignore[arg-type]
            limit,
            table.oil_temperature_C,
            lubrication,
            table.required_safety,
            factors | load_factors(table),
        )

    def rate(self, steps: Sequence[WornStep]) -> Rated:
        """Safeties at every wear step."""
        return rated_locally(steps, self._safety)

    def _safety(self, contact: RatedContact) -> FloatArray:
        _, flash = self.heat.conditions_and_flash(contact)
        mean = mean_flash_temperature(np.where(contact.rated, flash, 0.0), contact.teeth.rolls.roll)
        if self.method == "integral_temperature":
            bulk = bulk_temperature_integral(self.oil_temperature, mean, self.lubrication)
            return np.broadcast_to(integral_temperature_safety(bulk, mean, self.limit), flash.shape)
        bulk = bulk_temperature_flash(self.oil_temperature, mean, self.lubrication)
        return flash_temperature_safety(bulk + flash, self.limit, self.oil_temperature)
