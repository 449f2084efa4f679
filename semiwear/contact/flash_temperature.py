"""Flash temperature of a line contact: a band of frictional heat that moves over two half-spaces."""

from __future__ import annotations

from dataclasses import dataclass
from math import exp, log, pi
from typing import Literal

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.contact.conditions import ContactConditions

_EULER = float(np.euler_gamma)
_FAST = 1.11 / 2.0  # k theta sqrt(Pe) / heat per length, Pe -> infinity: Blok's 1.11 with 2b and Pe = v b/(2 kappa)
_SLOW = 4.0 * exp(0.5 - _EULER)  # k theta / heat per length = ln(_SLOW/Pe)/pi, Pe -> 0


@dataclass(frozen=True)
class FlashTemperature:
    """Greatest rise of the surface temperature in a loaded slice.

    The heat per length mu q |v_s| is spread like the Hertz pressure over the width 2b and divides between the bodies
    so that their greatest temperatures agree.

    ``"blok"``: for fast surfaces,

        theta = 1.11 mu q |v_s| / (B (sqrt|v1| + sqrt|v2|) sqrt(2b)),   B = sqrt(k rho c)

    (Blok 1937, Proc. General Discussion on Lubrication 2, 222-235; ISO/TR 13989-1:2000; ISO/TS 6336-20:2017). The
    exact coefficient of the semi-elliptic band is 1.1115. Meant for Peclet numbers v b/(2 kappa) above 5, where it is
    good to 0.3 %; it is 6 % too high at 1. It never exceeds the rise of the standing band below.

    ``"tian_kennedy"``: for any speed, theta = mu q |v_s| / (k/F(Pe1) + k/F(Pe2)) with Pe = |v| b/(2 kappa). Tian and
    Kennedy (1994, J. Tribology 116, 167-174) join the standing and the fast solution of a circular source by
    1/sqrt(Pe + 1.2344). For a band, whose standing solution is unbounded, the same joins the two limits of Jaeger's
    integral (1942, J. Proc. R. Soc. N.S.W. 76, 203-224):

        F(Pe) = asinh(0.555 pi sqrt(Pe + 1.127)/Pe) / pi,

    within 1.3 % of the integral at every Peclet number. A band of finite length 2a stays bounded: its standing value
    (ln(4 a/b) + 1/2)/pi is that of a moving one at Pe_0 = exp(-gamma) b/a, and F is taken at sqrt(Pe^2 + Pe_0^2),
    within 5 % of the integral over a finite band. Surfaces that move in opposite directions exchange heat like a
    counterflow, and are up to a fifth hotter than either model predicts.

    Attributes
    ----------
    model : {"blok", "tian_kennedy"}
    bulk_temperature_C : float
    conductivity_W_per_mK, density_kg_per_m3, specific_heat_J_per_kgK : float
        Of both bodies.
    aspect : float
        Length over width a/b of the contact; its logarithm bounds the rise of slow contacts and nothing else.
    """

    model: Literal["blok", "tian_kennedy"]
    bulk_temperature_C: float
    conductivity_W_per_mK: float
    density_kg_per_m3: float
    specific_heat_J_per_kgK: float
    aspect: float = 40.0

    @property
    def diffusivity(self) -> float:
        """Thermal diffusivity kappa [mm^2/s]."""
        return 1e6 * self.conductivity_W_per_mK / (self.density_kg_per_m3 * self.specific_heat_J_per_kgK)

    def peclet_number(self, conditions: ContactConditions) -> FloatArray:
        """|v| b / (2 kappa) of the driving and the driven surface, (2, roll, face)."""
        return np.abs(conditions.surface_speed) * conditions.half_width / (2.0 * self.diffusivity)

    def rise(self, conditions: ContactConditions, friction: FloatArray) -> FloatArray:
        """Flash temperature [K], (roll, face); 0 where there is no load.

        Parameters
        ----------
        conditions : ContactConditions
        friction : (roll, face) array
            Coefficient of friction.
        """
        heat = friction * conditions.line_load * conditions.sliding_speed  # N/s, which is W/m
        peclet = self.peclet_number(conditions)
        conductance = self._fast(peclet) if self.model == "blok" else self._any_speed(peclet)
        return heat / (self.conductivity_W_per_mK * conductance)

    def contact_temperature(self, conditions: ContactConditions, friction: FloatArray) -> FloatArray:
        """Bulk and flash temperature together [degC], (roll, face)."""
        return self.bulk_temperature_C + self.rise(conditions, friction)

    def _fast(self, peclet: FloatArray) -> FloatArray:
        standing = 2.0 * pi / (log(4.0 * self.aspect) + 0.5)
        return np.asarray(np.maximum(np.sqrt(peclet).sum(axis=0) / _FAST, standing))

    def _any_speed(self, peclet: FloatArray) -> FloatArray:
        held = np.hypot(peclet, exp(-_EULER) / self.aspect)
        slow = (_SLOW / (2.0 * pi * _FAST)) ** 2
        return np.asarray((pi / np.arcsinh(pi * _FAST * np.sqrt(held + slow) / held)).sum(axis=0))
