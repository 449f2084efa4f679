"""Film of the C-GF test gear at the load stages of the FVA-FZG micropitting test (FVA 54/7, C-GF/8,3/90).

Test gears: centre distance 91.5 mm, 16 and 24 teeth of module 4.5 mm, 14 mm wide, without flank modification
(Hoehn, Oster, Tobie and Michaelis 2008, Goriva i maziva 47, 129-152); 2250 rpm of the pinion, nominally 8.3 m/s;
oil at 90 degrees Celsius, sprayed. The torques of the stages are those of FVA information sheet 54/7, and give its
pressures at the pitch point, 795, 945, 1094, 1245, 1395 and 1547 MPa, within 0.3 %. For the start of contact, a
program that rates to ISO/TR 15144-1:2014 prints 236.3 N/mm in stage 10 (tests/reference/worked_examples.toml); the
same load share is used for all stages.
"""

from __future__ import annotations

from math import acos, cos, hypot, pi, radians, sin, sqrt, tan

import numpy as np

from semiwear.closed_forms import effective_modulus
from semiwear.contact.conditions import ContactConditions
from semiwear.contact.flash_temperature import FlashTemperature
from semiwear.ratings.oil import LUBRICANT_FACTOR, Oil
from semiwear.ratings.specific_film import FilmContact, specific_film

TEST_TORQUE_NM = {5: 70.0, 6: 98.9, 7: 132.5, 8: 171.6, 9: 215.6, 10: 265.1}  # of the pinion, by load stage

_TEETH, _MODULE, _WIDTH, _CENTRES, _TIPS = (16, 24), 4.5, 14.0, 91.5, (82.46, 118.36)
_SPEED = 2250.0 * pi / 30.0  # rad/s
_OIL_TEMPERATURE, _ROUGHNESS = 90.0, 0.5
_SHARE = 0.4222  # load share at the start of contact: 236.3 of 559.8 N/mm in stage 10
_STEEL = 206e3, 0.3
_CONDUCTIVITY, _DENSITY, _HEAT = 45.0, 7800.0, 440.0


def mean_friction(
    line_load: float, sum_speed: float, radius: float, viscosity: float, roughness: float, lubricant_factor: float
) -> float:
    """Mean coefficient of friction of a mesh, 0.045 (q/(v_sum R))^0.2 eta^-0.05 X_R X_L, X_R = 2.2 (Ra/R)^0.25.

    ISO/TR 15144-1:2014, eq. 86, and ISO/TR 13989-2:2000, eq. 1, with the load of one pair at the pitch point.

    Parameters
    ----------
    line_load : float [N/mm]
    sum_speed : float [m/s]
        At the pitch point.
    radius : float [mm]
        Relative radius of curvature at the pitch point.
    viscosity : float [mPa s]
        At the oil temperature.
    roughness : float [um]
        Mean of both flanks' Ra.
    lubricant_factor : float
        X_L.
    """
    x_r = 2.2 * (roughness / radius) ** 0.25
    return float(0.045 * (line_load / (sum_speed * radius)) ** 0.2 * viscosity**-0.05 * x_r * lubricant_factor)


def bulk_temperature(
    oil_temperature: float, power_loss: float, area: float, lubrication_factor: float = 1.2
) -> float:
    """Temperature of the teeth theta_M = theta_oil + 7400 (P_loss/(a b))^0.72 X_S/1.2 [degC] without tip relief.

    Parameters
    ----------
    oil_temperature : float [degC]
    power_loss : float [kW]
        P mu H_V of the mesh.
    area : float [mm^2]
        Centre distance times face width, a b.
    lubrication_factor : float
        X_S: 1.2 sprayed, 1 dipped, 0.2 submerged.

    Source: Oster 1982 in ISO/TR 15144-1:2014, eq. 84.
    """
    return oil_temperature + 7400.0 * float((power_loss / area) ** 0.72) * lubrication_factor / 1.2


def film_of_test(oil: Oil, load_stage: float) -> float:
    """lambda_GFT: specific film of an oil on the test gear at the start of contact, for a load stage of 5 to 10.

    It is the least on the path of contact of these gears. The torque is interpolated between stages.
    """
    stages = sorted(TEST_TORQUE_NM)
    torque = float(np.interp(load_stage, stages, [TEST_TORQUE_NM[stage] for stage in stages]))
    base = [0.5 * z * _MODULE * cos(radians(20.0)) for z in _TEETH]
    angle = acos(sum(base) / _CENTRES)
    action = _CENTRES * sin(angle)
    tip_radius = [sqrt((0.5 * tip) ** 2 - b**2) for tip, b in zip(_TIPS, base, strict=True)]
    pitch_radius = [b * tan(angle) for b in base]
    modulus = effective_modulus(*_STEEL, *_STEEL)

    line_load = 1e3 * torque / base[0] / _WIDTH
    at_pitch = pitch_radius[0] * pitch_radius[1] / action
    friction = mean_friction(
        line_load,
        2e-3 * _SPEED * pitch_radius[0],
        at_pitch,
        float(oil.dynamic_viscosity(_OIL_TEMPERATURE)),
        _ROUGHNESS,
        LUBRICANT_FACTOR[oil.family],
    )
    loss = 1e-3 * torque * _SPEED * friction * _loss_factor(base, tip_radius, pitch_radius)
    bulk = bulk_temperature(_OIL_TEMPERATURE, loss, _CENTRES * _WIDTH)

    radii = np.array([action - tip_radius[1], tip_radius[1]])  # of curvature at the start of contact: pinion, gear
    speed = _SPEED * radii * (1.0, _TEETH[0] / _TEETH[1])
    load, curvature = np.full((1, 1), _SHARE * line_load), np.full((1, 1), action / float(radii.prod()))
    conditions = ContactConditions.hertz(load, curvature, speed[:, None, None], modulus)
    flash = FlashTemperature("blok", bulk, _CONDUCTIVITY, _DENSITY, _HEAT)
    hot = flash.contact_temperature(conditions, np.full((1, 1), friction))
    contact = FilmContact(conditions.sum_speed, conditions.pressure, curvature, hot, modulus)
    return float(specific_film(contact, oil, bulk, _ROUGHNESS)[0, 0])


def _loss_factor(base: list[float], tip_radius: list[float], pitch_radius: list[float]) -> float:
    """Loss factor H_V of the spur pair (Ohlendorf 1958)."""
    pitch = 2.0 * pi * base[0] / _TEETH[0]
    first, second = ((tip - at) / pitch for tip, at in zip(tip_radius, pitch_radius, strict=True))
    return pi * (1.0 / _TEETH[0] + 1.0 / _TEETH[1]) * (1.0 - first - second + hypot(first, second) ** 2)
