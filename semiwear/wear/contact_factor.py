"""Factor on the wear coefficient where it depends on the contact."""

from __future__ import annotations

from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Protocol

import numpy as np

from semiwear.arrays import FloatArray
from semiwear.contact.line_conditions import line_conditions
from semiwear.contact.loaded_teeth import LoadedState, LoadedTeeth
from semiwear.contact.loads import TeethLoads
from semiwear.errors import ConvergenceError
from semiwear.meshing.surface_speed import SurfaceSpeeds
from semiwear.wear.laws import ContactLaw

if TYPE_CHECKING:
    from semiwear.contact.running_in import RunningIn


class Clock(Protocol):
    """Stopwatch that adds up seconds by effect."""

    def measure(self, effect: str) -> AbstractContextManager[None]:
        """Count the time spent within the context."""


@dataclass(frozen=True)
class ContactFactor:
    """Product of the laws of the wear coefficient.

    Attributes
    ----------
    laws : mapping from the name of an effect to its ContactLaw
    speeds : SurfaceSpeeds
        At the solved roll positions.
    clock : Clock
    running_in : RunningIn, optional
        Change of the roughness under the film.
    """

    laws: dict[str, ContactLaw]
    speeds: SurfaceSpeeds
    clock: Clock
    running_in: RunningIn | None = None

    def __call__(self, teeth: LoadedTeeth, loads: TeethLoads, state: LoadedState) -> FloatArray:
        """Factor of every slice, (roll, face); 1 where there is no load."""
        conditions = line_conditions(teeth.problem, loads, state.coarse, self.speeds)
        if self.running_in is not None:
            with self.clock.measure("running_in"):
                ratio = self.running_in.of_both(teeth, state, state.coarse.profile)
            conditions = replace(conditions, roughness_ratio=ratio)
        product = np.ones(conditions.line_load.shape)
        for name, law in self.laws.items():
            with self.clock.measure(name):
                factor = np.where(conditions.loaded, law.factor(conditions), 1.0)
                if not np.isfinite(factor).all():
                    at = float(conditions.pressure[~np.isfinite(factor)].min())
                    raise ConvergenceError(
                        f"effects.{name}: the wear coefficient has no finite value where the pressure is {at:.3g} "
                        "MPa; give values nearer to usual ones"
                    )
                product = product * factor
        return product
