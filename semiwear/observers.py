"""Quantities of a loaded state that do not change it: friction loss, temperature, oil film.

Names and units of the results are defined in `semiwear.results.schema`. Greatest and least values are taken over the
slices that count as away from edges.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from semiwear.arrays import BoolArray, FloatArray
from semiwear.contact.conditions import ContactConditions
from semiwear.contact.film_thickness import FilmThickness
from semiwear.contact.flash_temperature import FlashTemperature
from semiwear.contact.friction import Friction, power_loss
from semiwear.contact.line_conditions import line_conditions
from semiwear.contact.loaded_teeth import LoadedState, LoadedTeeth
from semiwear.contact.loads import SlicePressures
from semiwear.meshing.surface_speed import SurfaceSpeeds

Arrays = dict[str, np.ndarray]


class Observer(Protocol):
    """An effect that evaluates a loaded state."""

    @property
    def effect(self) -> str:
        """Name of the effect."""

    def engagement(self, teeth: LoadedTeeth, state: LoadedState, pressure: SlicePressures) -> Arrays:
        """Quantities at every roll position."""

    def history(self, teeth: LoadedTeeth, engagement: Mapping[str, np.ndarray]) -> Arrays:
        """Quantities of the wear state, from those of `engagement`."""


def _conditions(teeth: LoadedTeeth, state: LoadedState, speeds: SurfaceSpeeds) -> ContactConditions:
    return line_conditions(teeth.problem, state.loads, state.coarse, speeds)


def _greatest(values: FloatArray, pressure: SlicePressures) -> FloatArray:
    """Greatest value away from edges at each roll position; 0 where no slice bears load, NaN where only edges do."""
    counts, borders = pressure.inner > 0.0, (pressure.border > 0.0).any(axis=1)
    greatest = np.max(values, axis=1, where=counts, initial=0.0)
    return np.where(borders & ~counts.any(axis=1), np.nan, greatest)


def _least(values: FloatArray, counts: BoolArray) -> FloatArray:
    """Least value of the slices that count at each roll position; NaN where there are none."""
    least = np.min(values, axis=1, where=counts, initial=np.inf)
    return np.where(np.isfinite(least), least, np.nan)


@dataclass(frozen=True)
class FrictionLoss:
    """Coefficient of friction, power loss and efficiency of the mesh.

    Attributes
    ----------
    speeds : SurfaceSpeeds
    friction : Friction
    power : float [W]
        Input power at the speed of `speeds`.
    speed_known : bool
        Whether the scene gives the speed, so that the loss is in watts.
    """

    speeds: SurfaceSpeeds
    friction: Friction
    power: float
    speed_known: bool
    effect: str = "friction"

    def engagement(self, teeth: LoadedTeeth, state: LoadedState, pressure: SlicePressures) -> Arrays:
        """Mean coefficient, weighted with the load, and power loss (or torque loss) at every roll position."""
        conditions = _conditions(teeth, state, self.speeds)
        coefficient, length = self.friction.coefficient_of(conditions), teeth.lines.length
        force = conditions.line_load * length
        total = force.sum(axis=1)
        mean = np.where(total > 0.0, (coefficient * force).sum(axis=1) / np.where(total > 0.0, total, 1.0), np.nan)
        loss = power_loss(conditions, coefficient, length, self.speeds.sliding_in_parts)
        return {"friction_coefficient": mean, self._loss: loss}

    def history(self, teeth: LoadedTeeth, engagement: Mapping[str, np.ndarray]) -> Arrays:
        """Efficiency and mean power loss of the mesh."""
        # mesh positions are evenly spaced: the mean over the mesh is the sum over all pairs over their number
        loss = engagement[self._loss].sum() / teeth.rolls.phase.size
        found = {"mesh_efficiency": np.asarray(1.0 - loss / self.power)}
        return found | ({"friction_power_loss_mean": np.asarray(loss)} if self.speed_known else {})

    @property
    def _loss(self) -> str:
        """Name of the loss: without a speed the pinion turns by 1 rad/s, and 1 W is 1 N m."""
        return "friction_power_loss" if self.speed_known else "friction_torque_loss"


@dataclass(frozen=True)
class Heat:
    """Flash temperature and contact temperature."""

    speeds: SurfaceSpeeds
    friction: Friction
    flash: FlashTemperature
    effect: str = "flash_temperature"

    def engagement(self, teeth: LoadedTeeth, state: LoadedState, pressure: SlicePressures) -> Arrays:
        """Greatest rise of the surface temperature at every roll position."""
        conditions = _conditions(teeth, state, self.speeds)
        rise = self.flash.rise(conditions, self.friction.coefficient_of(conditions))
        return {"flash_temperature_max": _greatest(rise, pressure)}

    def history(self, teeth: LoadedTeeth, engagement: Mapping[str, np.ndarray]) -> Arrays:
        """Greatest contact temperature of the engagement."""
        greatest = np.fmax.reduce(engagement["flash_temperature_max"])
        return {"contact_temperature_max": np.asarray(self.flash.bulk_temperature_C + greatest)}


@dataclass(frozen=True)
class Film:
    """Film thickness and its ratio to the roughness."""

    speeds: SurfaceSpeeds
    film: FilmThickness
    effect: str = "lubrication"

    def engagement(self, teeth: LoadedTeeth, state: LoadedState, pressure: SlicePressures) -> Arrays:
        """Least film thickness at every roll position."""
        least = self.film.minimum(_conditions(teeth, state, self.speeds))
        return {"film_thickness_min": _least(least, pressure.inner > 0.0)}

    def history(self, teeth: LoadedTeeth, engagement: Mapping[str, np.ndarray]) -> Arrays:
        """Least ratio of film thickness to roughness of the engagement, where there is contact."""
        least = np.fmin.reduce(engagement["film_thickness_min"])
        return {"lambda_ratio_min": np.asarray(least / self.film.roughness_um)}
