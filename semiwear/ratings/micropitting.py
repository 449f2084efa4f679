"""Micropitting: film thickness over roughness, against the value at which the test gear shows micropitting.

The local method (A) of ISO/TS 6336-22:2018, evaluated in every slice of the contact lines.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from semiwear.arrays import FloatArray
from semiwear.contact.flash_temperature import FlashTemperature
from semiwear.contact.friction import Friction
from semiwear.meshing.flank_pair import DRIVEN
from semiwear.ratings.contact import RatedContact, WornStep
from semiwear.ratings.heated_contact import FrictionalHeat
from semiwear.ratings.load_factors import load_factors
from semiwear.ratings.load_stages import film_of_test
from semiwear.ratings.mode import Rated, rated_locally
from semiwear.ratings.oil import Oil
from semiwear.ratings.specific_film import FilmContact, permissible_film, specific_film
from semiwear.scene import oil_rating_tables as tables

if TYPE_CHECKING:
    from semiwear.contact.running_in import RunningIn

MICROPITTING_SOURCE = "ISO/TR 15144-1:2014 (ISO/TS 6336-22:2018), formulas as an open program quotes them"


@dataclass(frozen=True)
class Micropitting:
    """Safety against micropitting S_lambda = lambda_GF/lambda_GFP in every slice.

    Attributes
    ----------
    heat : FrictionalHeat
    oil : Oil
    bulk_temperature : float [degC]
    roughness : float [um]
        Mean of both flanks' Ra when new.
    permissible : float
        lambda_GFP.
    required_safety : float
    running_in : RunningIn, optional
        Change of the roughness with wear.
    factors : mapping
    """

    heat: FrictionalHeat
    oil: Oil
    bulk_temperature: float
    roughness: float
    permissible: float
    required_safety: float
    running_in: RunningIn | None = None
    factors: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        table: tables.Micropitting,
        flash: FlashTemperature,
        friction: Friction,
        running_in: RunningIn | None = None,
    ) -> Micropitting:
        """The mode of a scene's table."""
        oil = Oil.of(table)
        if table.limit == "given":
            assert table.permissible_film is not None  # a rule of the scene
            permissible, origin = table.permissible_film, "given"
        else:
            assert table.load_stage is not None  # a rule of the scene
            permissible = permissible_film(film_of_test(oil, table.load_stage), table.material_factor)
            origin = f"the test gears with this oil in load stage {table.load_stage:g} of C-GF/8,3/90"
        smooth = "" if running_in is None else f" when new, {1.0 - running_in.share:g} times that when run in"
        factors = {
            "lambda_GFP": f"{permissible:.4g}: {origin}",
            "W_W": f"{table.material_factor:g}: given",
            "Ra": f"{table.roughness_Ra_um:g} um: given{smooth}",
            "theta_M": f"{table.bulk_temperature_C:g} degrees Celsius: given",
            "X_Y": "1: the load sharing is solved",
            "source": MICROPITTING_SOURCE,
        }
        return cls(
            FrictionalHeat(flash, friction, table.load_factor),
            oil,
            table.bulk_temperature_C,
            table.roughness_Ra_um,
            permissible,
            table.required_safety,
            running_in,
            factors | load_factors(table),
        )

    def rate(self, steps: Sequence[WornStep]) -> Rated:
        """Safeties at every wear step."""
        return rated_locally(steps, self._safety)

    def _safety(self, contact: RatedContact) -> FloatArray:
        conditions, flash = self.heat.conditions_and_flash(contact)
        film_contact = FilmContact(
            conditions.sum_speed,
            conditions.pressure,
            conditions.curvature,
            self.bulk_temperature + flash,
            contact.teeth.problem.modulus,
        )
        film = specific_film(film_contact, self.oil, self.bulk_temperature, self.roughness)
        safety = film / self.permissible
        if self.running_in is None:
            return safety
        return safety / self.running_in.of_both(contact.teeth, contact.state, contact.places[DRIVEN])
