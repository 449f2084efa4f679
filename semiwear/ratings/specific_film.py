"""Specific film thickness between loaded flanks, reduced by the heat of sliding (ISO/TS 6336-22).

The standard's text was not at hand: the formulas are those of its predecessor ISO/TR 15144-1:2014, as quoted by the
open program Mekanika (mekanika.org, 2026); the factor of 1.4 is that of a commercial program's reports
(tests/reference/worked_examples.toml).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.ratings.oil import Oil

_TEST_TO_LIMIT = 1.4  # lambda_GFP over the film of the test gear at its failure load stage


@dataclass(frozen=True, eq=False)
class FilmContact:
    """Contact of two flanks, input of the film formula; all arrays have the same shape.

    Attributes
    ----------
    sum_speed : array [mm/s]
        |v1 + v2| across the line.
    pressure : array [MPa]
        Greatest Hertz pressure.
    curvature : array [1/mm]
        Relative curvature across the line.
    temperature : array [degC]
        Contact temperature, bulk and flash together.
    effective_modulus : float [MPa]
        E*, half of E_r in the formulas.
    """

    sum_speed: FloatArray
    pressure: FloatArray
    curvature: FloatArray
    temperature: FloatArray
    effective_modulus: float


def specific_film(contact: FilmContact, oil: Oil, bulk_temperature: float, roughness: float) -> FloatArray:
    """Specific film thickness lambda_GF = h/Ra, with h = 1.6 R G^0.6 U^0.7 W^-0.13 S^0.22.

    G = alpha E_r and U = eta v_sum/(2 E_r R) are taken at the bulk temperature, W = 2 pi (p/E_r)^2 is q/(E_r R), and
    S = (alpha eta at the contact temperature)/(alpha eta at the bulk temperature) is the influence of the heat of
    sliding (ISO/TR 15144-1:2014, eqs. 2 to 33). For flooded contacts of steel flanks.

    Parameters
    ----------
    contact : FilmContact
    oil : Oil
    bulk_temperature : float [degC]
        Of the teeth.
    roughness : float [um]
        Mean of both flanks' Ra.

    Returns
    -------
    array
        Of the shape of the contact's arrays; infinite without pressure.
    """
    modulus = 2.0 * contact.effective_modulus
    loaded = contact.pressure > 0.0
    curvature = np.where(loaded, contact.curvature, 1.0)
    pressure = np.where(loaded, contact.pressure, 1.0)
    viscosity, coefficient = oil.dynamic_viscosity(bulk_temperature), oil.pressure_viscosity(bulk_temperature)
    material = 1e-3 * coefficient * modulus
    speed = 1e-9 * viscosity * 0.5 * contact.sum_speed * curvature / modulus
    load = 2.0 * pi * (pressure / modulus) ** 2
    heat = oil.dynamic_viscosity(contact.temperature) * oil.pressure_viscosity(contact.temperature)
    sliding = heat / (viscosity * coefficient)
    film = 1.6e3 / curvature * material**0.6 * speed**0.7 * load**-0.13 * sliding**0.22
    return np.where(loaded, film / roughness, np.inf)


def permissible_film(test_film: float, material_factor: float = 1.0) -> float:
    """Permissible specific film lambda_GFP = 1.4 W_W lambda_GFT of a tested oil.

    Parameters
    ----------
    test_film : float
        lambda_GFT, least specific film of the test gear at the load stage at which it failed.
    material_factor : float
        W_W: 1 for case-hardened gears, as those of the test.
    """
    return _TEST_TO_LIMIT * material_factor * test_film
