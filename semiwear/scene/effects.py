"""Optional effects, one table each: an effect is active if and only if its table is present, even if empty."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from operator import attrgetter
from typing import get_args, get_type_hints

from semiwear.scene.effect_table import EffectTable
from semiwear.scene.flank_fracture_table import FlankFracture
from semiwear.scene.mechanical_effects import (
    FlankModification,
    FreeEdges,
    LoadSpectrum,
    Misalignment,
    PitchError,
    RunLife,
    ShaftCompliance,
)
from semiwear.scene.oil_rating_tables import Micropitting, Scuffing
from semiwear.scene.rating_tables import Bending, Pitting, RatingTable
from semiwear.scene.running_in_table import RunningIn
from semiwear.scene.tribological_effects import FlashTemperature, Friction, Lubrication
from semiwear.scene.wear_laws import HardnessLaw, LoadLaw, LubricationLaw, TemperatureLaw, WearLaws

__all__ = [
    "EFFECTS",
    "Bending",
    "EffectTable",
    "Effects",
    "FlankFracture",
    "FlankModification",
    "FlashTemperature",
    "FreeEdges",
    "Friction",
    "HardnessLaw",
    "LoadLaw",
    "LoadSpectrum",
    "Lubrication",
    "LubricationLaw",
    "Micropitting",
    "Misalignment",
    "Modifications",
    "PitchError",
    "Pitting",
    "RatingTable",
    "RunLife",
    "RunningIn",
    "Scuffing",
    "ShaftCompliance",
    "TemperatureLaw",
    "WearLaws",
]


@dataclass(frozen=True, kw_only=True)
class Modifications:
    """The modified flanks: tables under ``[effects.modification]``; None is an unmodified flank."""

    pinion: FlankModification | None = None
    gear: FlankModification | None = None


@dataclass(frozen=True, kw_only=True)
class Effects:
    """Table ``[effects]``: every effect of a scene; None for an absent effect."""

    misalignment: Misalignment | None = None
    modification: Modifications = field(default_factory=Modifications)
    free_edges: FreeEdges | None = None
    friction: Friction | None = None
    flash_temperature: FlashTemperature | None = None
    lubrication: Lubrication | None = None
    wear_law: WearLaws = field(default_factory=WearLaws)
    running_in: RunningIn | None = None
    load_spectrum: LoadSpectrum | None = None
    pitch_error: PitchError | None = None
    shaft_compliance: ShaftCompliance | None = None
    pitting: Pitting | None = None
    bending: Bending | None = None
    micropitting: Micropitting | None = None
    scuffing: Scuffing | None = None
    flank_fracture: FlankFracture | None = None
    run_life: RunLife | None = None

    def get(self, name: str) -> EffectTable | None:
        """Table of an effect named as in `EFFECTS`, or None if it is absent.

        Raises
        ------
        KeyError
            For a name that no effect has.
        """
        if name not in EFFECTS:
            raise KeyError(f"no effect {name!r}; there are {', '.join(EFFECTS)}")
        table: EffectTable | None = attrgetter(name)(self)
        return table

    def present(self) -> Iterator[tuple[str, EffectTable]]:
        """Name and table of every present effect, in the order of `EFFECTS`."""
        for name in EFFECTS:
            table = self.get(name)
            if table is not None:
                yield name, table


def _effects_of(container: type, prefix: str = "") -> Iterator[tuple[str, type[EffectTable]]]:
    """Dotted names below ``[effects]`` and tables of the effects in a container."""
    for name, hint in get_type_hints(container).items():
        kind = next((option for option in get_args(hint) if option is not type(None)), hint)
        if issubclass(kind, EffectTable):
            yield f"{prefix}{name}", kind
        else:
            yield from _effects_of(kind, f"{prefix}{name}.")


EFFECTS: dict[str, type[EffectTable]] = dict(_effects_of(Effects))
"""Tables of all effects, by the dotted name below ``[effects]`` in a scene file."""
