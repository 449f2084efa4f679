"""Wear of plastic gears after VDI 2736 Part 2:2014: the mean depth along a flank, its limit and the temperature.

A global estimate, to be compared with the wear that is computed locally: friction work times a coefficient, spread
evenly over the active flank. Its volume is that of the local wear of unworn flanks; it accounts neither for the
distribution of the sliding nor for the change of the load sharing by wear. The formulas are as an open program quotes
them.
"""

from __future__ import annotations

from math import pi

import numpy as np
from numpy.typing import ArrayLike

from semiwear.argument_ranges import require_range
from semiwear.arrays import FloatArray


def loss_factor(teeth: tuple[int, int], contact_ratios: tuple[float, float], base_helix_cosine: float = 1.0) -> float:
    """Loss factor H_V of a cylindrical pair (VDI 2736-2:2014, eq. 8; Ohlendorf 1958).

    pi (u + 1)/(z_2 cos beta_b) (1 - eps_1 - eps_2 + eps_1^2 + eps_2^2), with the load shared evenly.

    Parameters
    ----------
    teeth : (z_1, z_2)
        The gear's negative in an internal pair.
    contact_ratios : (eps_1, eps_2)
        Of the pinion's and the gear's addendum; neither above 1, together 1 to 2.
    base_helix_cosine : float
        cos beta_b.

    Raises
    ------
    ValueError
        A number is out of its range.
    """
    require_range("the number of teeth", np.abs(teeth), least=1)
    require_range("the contact ratio of an addendum", contact_ratios, least=0.0, most=1.0)
    require_range("the transverse contact ratio", sum(contact_ratios), least=1.0, most=2.0)
    require_range("the cosine of the base helix angle", base_helix_cosine, above=0.0, most=1.0)
    first, second = contact_ratios
    spread = 1.0 - first - second + first**2 + second**2
    return pi * (1.0 / teeth[0] + 1.0 / teeth[1]) / base_helix_cosine * spread


def tooth_temperature(
    surroundings: float,
    friction_power: float,
    tooth_resistance: float,
    housing_resistance: float,
    duty: float = 1.0,
) -> float:
    """Tooth temperature [degC]: surroundings + P mu H_V (R_tooth + R_housing) ED^0.64 (VDI 2736-2:2014, eq. 9).

    Parameters
    ----------
    surroundings : float [degC]
    friction_power : float [W]
        P mu H_V.
    tooth_resistance : float [K/W]
        k_theta/(b z_1 (v_t m_n)^0.75), b and m_n in mm and v_t in m/s; k_theta from the guideline's table.
    housing_resistance : float [K/W]
        R_lambda,G over the housing's surface A_G.
    duty : float
        ED, fraction of the time that the gears run.

    Raises
    ------
    ValueError
        A number is out of its range.
    """
    require_range("the friction power", friction_power, "W", least=0.0)
    require_range("a thermal resistance", (tooth_resistance, housing_resistance), "K/W", least=0.0)
    require_range("the fraction of time that gears run", duty, least=0.0, most=1.0)
    return surroundings + friction_power * (tooth_resistance + housing_resistance) * float(duty**0.64)


def plastic_wear(
    torque: ArrayLike,
    cycles: ArrayLike,
    loss: float,
    wear_coefficient: ArrayLike,
    face_width: float,
    teeth: int,
    flank_length: float,
) -> FloatArray:
    """Mean wear depth W_m = 2 pi T N H_V k_w/(b z l_Fl) of a flank [mm] (VDI 2736-2:2014, eq. 19).

    Parameters
    ----------
    torque : array [N m]
        Of the worn gear.
    cycles : array
        Revolutions of the worn gear.
    loss : float
        H_V.
    wear_coefficient : array [mm^3/(N m)]
        k_w, Archard's coefficient; 1e-6 mm^3/(N m) are 1e-9 mm^2/N.
    face_width : float [mm]
    teeth : int
        Of the worn gear.
    flank_length : float [mm]
        l_Fl, length of the active profile.

    Raises
    ------
    ValueError
        A number is out of its range.
    """
    require_range("the torque", torque, "N m", least=0.0, missing=True)
    require_range("the number of cycles", cycles, least=0.0, missing=True)
    require_range("the loss factor", loss, least=0.0)
    require_range("the wear coefficient", wear_coefficient, "mm^3/(N m)", least=0.0, missing=True)
    require_range("the number of teeth", teeth, least=1)
    require_range("face width and length of the active profile", (face_width, flank_length), "mm", above=0.0)
    work = 2.0 * pi * np.asarray(torque, float) * np.asarray(cycles, float) * loss
    return np.asarray(work * np.asarray(wear_coefficient, float) / (face_width * teeth * flank_length))


def active_profile_length(base_radius: float, root_curvature: float, tip_curvature: float) -> float:
    """Length l_Fl = (rho_a^2 - rho_f^2)/(2 r_b) of an involute's active profile [mm] (VDI 2736-2:2014, eq. 20).

    Parameters
    ----------
    base_radius : float [mm]
    root_curvature, tip_curvature : float [mm]
        Radii of curvature at the ends of the active profile.

    Raises
    ------
    ValueError
        A number is out of its range.
    """
    require_range("the base radius", base_radius, "mm", above=0.0)
    require_range("the radius of curvature at the root", root_curvature, "mm", least=0.0)
    require_range("the radius of curvature at the tip", tip_curvature, "mm", least=root_curvature)
    return (tip_curvature**2 - root_curvature**2) / (2.0 * base_radius)


def permissible_wear(normal_module: float) -> float:
    """Usual permissible wear depth of plastic gears, 0.1 m_n [mm] (VDI 2736-2:2014)."""
    return 0.1 * normal_module


def of_temperature(temperature: ArrayLike, temperatures: ArrayLike, values: ArrayLike) -> FloatArray:
    """Young's modulus or wear coefficient at a temperature, linear between the points of a table.

    Parameters
    ----------
    temperature : array [degC]
        Within the table.
    temperatures : (n,) array [degC]
        Increasing.
    values : (n,) array

    Raises
    ------
    ValueError
        If a temperature lies outside the table: plastics change too fast for extrapolation.
    """
    at, known = np.asarray(temperature, float), np.asarray(temperatures, float)
    if at.size and (at.min() < known[0] or at.max() > known[-1]):
        raise ValueError(
            f"temperature: found {at.min():g} to {at.max():g} degC; allowed: {known[0]:g} to {known[-1]:g} degC"
            " -> extend the material's table"
        )
    return np.asarray(np.interp(at, known, np.asarray(values, float)))
