"""Friction of loaded contact lines, its power loss and its lever arms."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.contact.conditions import ContactConditions
from semiwear.contact.traction import full_sliding_speed, share_of_full_friction

_LEAST_LINE_LOAD = 150.0  # N/mm; below it the coefficient is held, as ISO/TR 13989-2:2000 holds it
_LEAST_SUM_SPEED = 1.0  # m/s
_WATT = 1e-3  # of one N mm/s


@dataclass(frozen=True)
class Friction:
    """Coefficient of friction of oiled teeth.

    ``"constant"``: the given coefficient.

    ``"iso_14179"``: the mean coefficient of a mesh,

        mu = 0.048 (q / (v_sum R))^0.2 eta^-0.05 Ra^0.25 X_L,

    with q in N/mm, v_sum in m/s, R in mm, eta in mPa s, Ra in um (Schlenk 1994, dissertation, TU Munich;
    ISO/TR 14179-2:2001; Hoehn, Michaelis and Hinterstoisser 2009, Goriva i maziva 48, 441-480). The older form
    (Niemann and Winter 1989, Maschinenelemente II) has 0.045 X_R with X_R = 3.8 (Ra/d1)^0.25 and the reference
    diameter d1 in mm of the driving gear; it is used where `reference_diameter_mm` is given. The two agree at
    d1 = 161 mm, and differ by 22 % at the 73 mm of the FZG test gears.

    Both are fits to whole meshes, at the pitch point's load, sum speed and radius. Here they are evaluated with those
    of each slice: accurate to the fifth root of what varies along the path, and without the drop to zero sliding
    at the pitch point. Fitted for line loads above 150 N/mm and pitch-line velocities of 1 to 50 m/s with mineral
    oil; line loads below 150 N/mm and sum speeds below 1 m/s count as these.

    Attributes
    ----------
    law : {"constant", "iso_14179"}
    coefficient : float
        Of the constant law.
    viscosity_mPas : float
        Dynamic viscosity of the oil at the temperature of the teeth.
    roughness_um : float
        Arithmetic mean roughness Ra, mean of the two flanks.
    lubricant_factor : float
        X_L: 1 for mineral oil, 0.8 for polyalphaolefins.
    reference_diameter_mm : float, optional
    """

    law: Literal["constant", "iso_14179"]
    coefficient: float = 0.0
    viscosity_mPas: float = 0.0
    roughness_um: float = 0.0
    lubricant_factor: float = 1.0
    reference_diameter_mm: float | None = None

    def coefficient_of(self, conditions: ContactConditions) -> FloatArray:
        """Coefficient of friction, (roll, face); 0 where there is no load."""
        if self.law == "constant":
            return np.where(conditions.loaded, self.coefficient, 0.0)
        load = np.maximum(conditions.line_load, _LEAST_LINE_LOAD)
        speed = np.maximum(1e-3 * conditions.sum_speed, _LEAST_SUM_SPEED)
        curvature = conditions.where_loaded(conditions.curvature)
        mean = self._oil_and_surface() * (load * curvature / speed) ** 0.2
        return np.where(conditions.loaded, mean, 0.0)

    def _oil_and_surface(self) -> float:
        if self.reference_diameter_mm is None:
            factor = 0.048 * self.roughness_um**0.25
        else:
            factor = 0.045 * 3.8 * (self.roughness_um / self.reference_diameter_mm) ** 0.25
        return float(factor * self.lubricant_factor * self.viscosity_mPas**-0.05)


def power_loss(
    conditions: ContactConditions, friction: FloatArray, length: FloatArray, speed: FloatArray | None = None
) -> FloatArray:
    """Power loss by friction at each roll position: the sum of mu q |v_s| over the line.

    Where sliding is so slow that a part of the contact sticks (`traction`), the friction force is less than mu q by
    the same share as in the balance of moments: the loss is then input power less output power.

    Parameters
    ----------
    conditions : ContactConditions
    friction : (roll, face) array
        Coefficient of friction.
    length : (face,) or (roll, face) array [mm]
        Length of the line in each slice.
    speed : (part, roll, face) array [mm/s], optional
        Sliding speed in even parts of each slice. Default: that of the conditions in the whole slice.

    Returns
    -------
    (roll,) array [W]
    """
    speed = conditions.sliding_speed[None] if speed is None else speed
    share = share_of_full_friction(speed, full_sliding_speed(conditions, friction))
    return np.asarray(_WATT * (friction * conditions.line_load * length * (share * speed).mean(axis=0)).sum(axis=-1))


def mesh_efficiency(loss: FloatArray, roll: FloatArray, input_power: float) -> float:
    """Efficiency of a mesh: 1 less the mean loss of all tooth pairs over the input power.

    With the load shared evenly among the pairs in contact, their sum being the nominal normal force, a constant
    coefficient and 1 <= eps_1 + eps_2 <= 2 with neither above 1, the loss of a spur pair is mu H_v, and

        H_v = pi (u + 1)/(z1 u) (1 - eps_1 - eps_2 + eps_1^2 + eps_2^2)

    (Ohlendorf 1958, dissertation, TU Munich; Niemann and Winter 1989).

    Parameters
    ----------
    loss : (roll,) array [W]
        Of one tooth pair, from entry to exit.
    roll : (roll,) array
        Roll positions in base pitches: one pair follows another at a distance of 1, so that the integral over a
        pair's engagement is the mean over a mesh of all pairs together.
    input_power : float [W]
    """
    return 1.0 - float((loss * np.gradient(roll)).sum()) / input_power
