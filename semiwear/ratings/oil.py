"""Viscosity, density and pressure-viscosity coefficient of a gear oil at any temperature."""

from __future__ import annotations

from dataclasses import dataclass
from math import log10
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from semiwear.arrays import FloatArray
from semiwear.scene import oil_rating_tables as tables

OilFamily = Literal["mineral", "polyalphaolefin", "polyglycol"]

_KELVIN = 273.15
_VISCOSITY_TEMPERATURES = 40.0, 100.0  # degrees Celsius, of the data sheet

# pressure-viscosity coefficient at 38 degrees Celsius [1/Pa]: factor and exponent of the viscosity in Pa s
_PRESSURE_VISCOSITY: dict[OilFamily, tuple[float, float]] = {
    "mineral": (2.657e-8, 0.1348),
    "polyalphaolefin": (1.466e-8, 0.0507),
    "polyglycol": (1.392e-8, 0.1572),
}

# X_L of ISO/TR 13989:2000 and ISO/TR 15144-1:2014; for polyglycols the value of those not soluble in water
LUBRICANT_FACTOR: dict[OilFamily, float] = {"mineral": 1.0, "polyalphaolefin": 0.8, "polyglycol": 0.7}


@dataclass(frozen=True)
class Oil:
    """A gear oil with the data of its data sheet.

    The formulas are those of ISO/TR 15144-1:2014 (now ISO/TS 6336-22:2018), eqs. 8 to 11 and 16 to 20, as quoted by
    the open program Mekanika (mekanika.org, 2026). Kinematic viscosity follows Walther (ASTM D341).

    Attributes
    ----------
    family : {"mineral", "polyalphaolefin", "polyglycol"}
    viscosity_40, viscosity_100 : float [mm^2/s]
        Kinematic viscosity at 40 and 100 degrees Celsius.
    density_15 : float [kg/m^3]
        At 15 degrees Celsius.
    """

    family: OilFamily
    viscosity_40: float
    viscosity_100: float
    density_15: float

    @classmethod
    def of(cls, table: tables.OilTable) -> Oil:
        """The oil of a scene's table."""
        return cls(
            table.oil_family,  # type: ignore[arg-type]
            table.viscosity_40_mm2_per_s,
            table.viscosity_100_mm2_per_s,
            table.density_15_kg_per_m3,
        )

    def kinematic_viscosity(self, temperature: ArrayLike) -> FloatArray:
        """Kinematic viscosity nu [mm^2/s] at a temperature [degC]: log log (nu + 0.7) = A - B log T."""
        first, second = (log10(log10(nu + 0.7)) for nu in (self.viscosity_40, self.viscosity_100))
        cold, hot = (log10(degrees + _KELVIN) for degrees in _VISCOSITY_TEMPERATURES)
        slope = (first - second) / (hot - cold)
        double_log = first + slope * (cold - np.log10(np.asarray(temperature, float) + _KELVIN))
        return np.asarray(10.0**10.0**double_log - 0.7)

    def density(self, temperature: ArrayLike) -> FloatArray:
        """Density [kg/m^3] at a temperature [degC]: the value at 15 degC, less 0.7 for each kelvin above 16 degC."""
        return np.asarray(self.density_15 - 0.7 * (np.asarray(temperature, float) + 273.0 - 289.0))

    def dynamic_viscosity(self, temperature: ArrayLike) -> FloatArray:
        """Dynamic viscosity [mPa s] at a temperature [degC] and ambient pressure."""
        return 1e-3 * self.kinematic_viscosity(temperature) * self.density(temperature)

    def pressure_viscosity(self, temperature: ArrayLike) -> FloatArray:
        """Pressure-viscosity coefficient alpha [1/GPa] at a temperature [degC].

        A power of the viscosity at 38 degC, times 1 + 516 (1/T - 1/311 K); 0 above 510 degC, where this factor would
        be negative.
        """
        factor, exponent = _PRESSURE_VISCOSITY[self.family]
        at_38 = 1e9 * factor * (1e-3 * self.dynamic_viscosity(38.0)) ** exponent
        absolute = np.asarray(temperature, float) + 273.0
        return np.asarray(at_38 * np.maximum(1.0 + 516.0 * (1.0 / absolute - 1.0 / 311.0), 0.0))
