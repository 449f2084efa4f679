"""Micropitting: the oil film over the roughness, against that at which a test gear begins to show grey stains.

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
        How the roughness changes with wear.
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
        """The mode that a scene's table asks for."""
        oil = Oil.of(table)
        if table.limit == "given":
            assert table.permissible_film is not None  # a rule of the scene
            permissible, why = table.permissible_film, "given"
        else:
            assert table.load_stage is not None  # a rule of the scene
            permissible = permissible_film(film_of_test(oil, table.load_stage), table.material_factor)
            why = f"the test gears with this oil in load stage {table.load_stage:g} of C-GF/8,3/90"
        smooth = "" if running_in is None else f" when new, {1.0 - running_in.share:g} times that when run in"
        told = {
            "lambda_GFP": f"{permissible:.4g}: {why}",
            "W_W": f"{table.material_factor:g}: given",
            "Ra": f"{table.roughness_Ra_um:g} um: given{smooth}",
            "theta_M": f"{table.bulk_temperature_C:g} degrees Celsius: given",
            "X_Y": "1: the load is shared by solving the contact",
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
            told | load_factors(table),
        )

    def rate(self, steps: Sequence[WornStep]) -> Rated:
        """Safeties at every wear step."""
        return rated_locally(steps, self._safety)

    def _safety(self, contact: RatedContact) -> FloatArray:
        conditions, flash = self.heat.felt(contact)
        met = FilmContact(
            conditions.sum_speed,
            conditions.pressure,
            conditions.curvature,
            self.bulk_temperature + flash,
            contact.teeth.problem.modulus,
        )
        film = specific_film(met, self.oil, self.bulk_temperature, self.roughness) / self.permissible
        if self.running_in is None:
            return film
        return film / self.running_in.of_both(contact.teeth, contact.state, contact.places[DRIVEN])
