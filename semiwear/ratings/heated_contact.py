"""Contact conditions under the rated load with the flash temperature, for modes that depend on temperature."""

from __future__ import annotations

from dataclasses import dataclass

from semiwear.arrays import FloatArray
from semiwear.contact.conditions import ContactConditions
from semiwear.contact.flash_temperature import FlashTemperature
from semiwear.contact.friction import Friction
from semiwear.ratings.contact import RatedContact
from semiwear.ratings.overload import raised


@dataclass(frozen=True)
class FrictionalHeat:
    """Frictional heat of the rated load.

    Attributes
    ----------
    flash : FlashTemperature
        Its temperature rise is used; each mode has its own bulk temperature.
    friction : Friction
    load_factor : float
        K_A K_v.
    """

    flash: FlashTemperature
    friction: Friction
    load_factor: float

    def conditions_and_flash(self, contact: RatedContact) -> tuple[ContactConditions, FloatArray]:
        """Conditions in every slice, and flash temperature [K], (roll, face)."""
        conditions = raised(contact.conditions, self.load_factor)
        return conditions, self.flash.rise(conditions, self.friction.coefficient_of(conditions))
