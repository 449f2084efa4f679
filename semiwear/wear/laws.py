"""Laws of the wear coefficient: factors by contact conditions, and hardness that falls with depth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.contact.conditions import ContactConditions
from semiwear.contact.film_thickness import FilmThickness
from semiwear.contact.flash_temperature import FlashTemperature
from semiwear.contact.friction import Friction
from semiwear.scene import wear_laws as tables
from semiwear.untyped import Value

_GAS_CONSTANT = 8.314462618e-3  # kJ/(mol K), CODATA 2018
_ZERO_CELSIUS = 273.15  # K
_LEAST_PRESSURE = 0.01  # of the reference pressure: below it a factor of negative power is constant


class ContactLaw(Protocol):
    """Factor of the wear coefficient that depends on the contact conditions."""

    def factor(self, conditions: ContactConditions) -> FloatArray:
        """Factor of the wear coefficient, (roll, face); 0 where there is no load."""


class ContactPhysics(Protocol):
    """Models of the contact from the scene's other effects; a law requests only the ones it needs."""

    def film(self) -> FilmThickness:
        """The oil film of ``[effects.lubrication]``."""

    def flash(self) -> FlashTemperature:
        """The temperature of ``[effects.flash_temperature]``."""

    def friction(self) -> Friction:
        """The friction that heats the flanks."""


@dataclass(frozen=True)
class LoadLaw:
    """Wear proportional to another power of pressure than Archard's first: a factor (p/p_ref)^exponent.

    A negative power has no value at zero pressure, which occurs wherever contacts close and open. Below a hundredth
    of the reference pressure the factor is therefore constant.

    Attributes
    ----------
    exponent : float
        In addition to Archard's 1.
    reference_pressure_MPa : float
        Greatest Hertz pressure at which the wear coefficient was measured.
    """

    exponent: float
    reference_pressure_MPa: float

    @classmethod
    def of(cls, table: tables.LoadLaw, physics: ContactPhysics) -> LoadLaw:
        """The law that a scene's table asks for."""
        return cls(table.exponent, table.reference_pressure_MPa)

    def factor(self, conditions: ContactConditions) -> FloatArray:
        """(p/p_ref)^exponent, (roll, face); 0 where there is no load."""
        relative = conditions.where_loaded(conditions.pressure / self.reference_pressure_MPa)
        if self.exponent < 0.0:
            relative = np.maximum(relative, _LEAST_PRESSURE)
        return np.where(conditions.loaded, relative**self.exponent, 0.0)


@dataclass(frozen=True)
class LubricationLaw:
    """Wear that decreases with the film thickness.

    The wear coefficient is that of boundary lubrication up to `boundary_lambda`, zero from `full_film_lambda` on, and
    linear in between: with 0.5 and 4 the factor is (2/7)(4 - lambda) (Priest and Taylor 2000, Wear 241, 193-203).

    Attributes
    ----------
    film : FilmThickness
    boundary_lambda, full_film_lambda : float
    strength : float
        Share of the wear that a full film prevents, 0 to 1.
    """

    film: FilmThickness
    boundary_lambda: float = 0.5
    full_film_lambda: float = 4.0
    strength: float = 1.0

    @classmethod
    def of(cls, table: tables.LubricationLaw, physics: ContactPhysics) -> LubricationLaw:
        """The law that a scene's table asks for."""
        return cls(physics.film(), table.boundary_lambda, table.full_film_lambda, table.strength)

    def factor(self, conditions: ContactConditions) -> FloatArray:
        """1 less the share of wear prevented by the film, (roll, face); 0 where there is no load."""
        beyond = self.film.lambda_ratio(conditions) - self.boundary_lambda
        ended = np.clip(beyond / (self.full_film_lambda - self.boundary_lambda), 0.0, 1.0)
        return np.where(conditions.loaded, 1.0 - self.strength * ended, 0.0)


@dataclass(frozen=True)
class TemperatureLaw:
    """Wear by a thermally activated process: exp(-Q/R_g (1/T - 1/T_ref)), with the contact temperature T.

    Arrhenius 1889, Z. Phys. Chem. 4, 226-248; for oxidative wear Quinn 1983, Tribology International 16, 257-271.

    Attributes
    ----------
    flash : FlashTemperature
    friction : Friction
    activation_energy_kJ_per_mol : float
        Q, positive where wear increases with temperature.
    reference_temperature_C : float
        Contact temperature at which the wear coefficient was measured.
    """

    flash: FlashTemperature
    friction: Friction
    activation_energy_kJ_per_mol: float
    reference_temperature_C: float

    @classmethod
    def of(cls, table: tables.TemperatureLaw, physics: ContactPhysics) -> TemperatureLaw:
        """The law that a scene's table asks for."""
        energy, reference = table.activation_energy_kJ_per_mol, table.reference_temperature_C
        return cls(physics.flash(), physics.friction(), energy, reference)

    def factor(self, conditions: ContactConditions) -> FloatArray:
        """Arrhenius's factor, (roll, face); 0 where there is no load."""
        mu = self.friction.coefficient_of(conditions)
        absolute = self.flash.contact_temperature(conditions, mu) + _ZERO_CELSIUS
        inverse = 1.0 / absolute - 1.0 / (self.reference_temperature_C + _ZERO_CELSIUS)
        return np.where(conditions.loaded, np.exp(-self.activation_energy_kJ_per_mol / _GAS_CONSTANT * inverse), 0.0)


CONTACT_LAWS: dict[str, Callable[[Value, ContactPhysics], ContactLaw]] = {
    "wear_law.lubrication": LubricationLaw.of,
    "wear_law.temperature": TemperatureLaw.of,
    "wear_law.load": LoadLaw.of,
}
"""Laws that depend on the contact, by the names of their effects; each is built from the scene's table."""


@dataclass(frozen=True, eq=False)
class HardnessLaw:
    """Archard's K/H on a case-hardened flank: dh/ds = H_surface/H(h).

    s is the wear of a flank with the surface hardness at all depths, h the wear of this flank. The hardness is that
    of the case down to half a transition above the case depth, that of the core from half a transition below it, and
    linear in between. The integral S(h) of H/H_surface equals s (Archard 1953, J. Appl. Phys. 24, 981-988; case depth
    as in ISO 18203:2016, between case and core).

    Attributes
    ----------
    surface_hardness, core_hardness : float
        Both in the same unit.
    case_depth : float [mm]
        Middle of the transition.
    transition : float [mm]
        Its length, at most twice the case depth; 0 for a step.
    surface : (face, profile) array, optional
        Hardness of the case over `surface_hardness`, for example of a harder band; above 0.
    """

    surface_hardness: float
    core_hardness: float
    case_depth: float
    transition: float
    surface: FloatArray | None = None

    def __post_init__(self) -> None:
        if self.surface_hardness <= 0.0 or self.core_hardness <= 0.0:
            raise ValueError("a hardness law needs hardnesses above 0")
        if not 0.0 <= self.transition <= 2.0 * self.case_depth:
            raise ValueError("the transition of a hardness law must lie between 0 and twice the case depth")
        if self.surface is not None and np.any(self.surface <= 0.0):
            raise ValueError("the surface factor of a hardness law must be above 0 everywhere")

    @property
    def _case(self) -> FloatArray:
        """Hardness of the case over `surface_hardness`."""
        return np.asarray(1.0 if self.surface is None else self.surface, dtype=np.float64)

    @property
    def _core(self) -> float:
        return self.core_hardness / self.surface_hardness

    @property
    def _top(self) -> float:
        """Depth at which the transition begins [mm]."""
        return self.case_depth - 0.5 * self.transition

    def factor(self, depth: FloatArray) -> FloatArray:
        """dh/ds = H_surface/H at a depth [mm], (face, profile)."""
        if self.transition > 0.0:
            softened = np.clip(depth - self._top, 0.0, self.transition) / self.transition
        else:
            softened = np.where(depth < self._top, 0.0, 1.0)
        return 1.0 / (self._case + (self._core - self._case) * softened)

    def advance(self, depth: FloatArray, increment: FloatArray) -> FloatArray:
        """Depth after an increment of s, the wear at the surface hardness.

        Exact, so that the result does not depend on how the increment is divided.

        Parameters
        ----------
        depth : (face, profile) array [mm]
        increment : (face, profile) array [mm]
            Not below 0.

        Returns
        -------
        (face, profile) array [mm]
        """
        advanced = self._depth(self._wear(depth) + increment)
        advanced = np.where(self._case == self._core, depth + increment / self._core, advanced)
        return np.maximum(depth, advanced)

    def _wear(self, depth: FloatArray) -> FloatArray:
        """S(h), the integral of H/H_surface from 0 to a depth [mm]."""
        within = np.clip(depth - self._top, 0.0, self.transition)
        softened = within / self.transition if self.transition > 0.0 else 0.0
        mean = self._case + 0.5 * (self._core - self._case) * softened
        below = np.maximum(depth - self._top - self.transition, 0.0)
        return self._case * np.minimum(depth, self._top) + mean * within + self._core * below

    def _depth(self, wear: FloatArray) -> FloatArray:
        """Depth h for a value of S(h) [mm]."""
        above = self._case * self._top
        across = 0.5 * (self._case + self._core) * self.transition
        within = np.clip(wear - above, 0.0, across)
        share = np.divide(within, across, out=np.zeros_like(within), where=across > 0.0)
        hardness = np.sqrt(self._case**2 + (self._core**2 - self._case**2) * share)  # S is quadratic in the depth
        below = np.maximum(wear - above - across, 0.0)
        return np.minimum(wear, above) / self._case + 2.0 * within / (self._case + hardness) + below / self._core
