"""Optional physics, one table each: an effect runs if and only if its table is there, even an empty one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from operator import attrgetter

from semiwear.scene.effect_table import EffectTable
from semiwear.scene.mechanical_effects import (
    FlankModification,
    FreeEdges,
    LoadSpectrum,
    Misalignment,
    PitchError,
    RunLife,
    ShaftCompliance,
)
from semiwear.scene.tribological_effects import (
    FlashTemperature,
    Friction,
    HardnessLaw,
    LoadLaw,
    Lubrication,
    LubricationLaw,
    TemperatureLaw,
)

__all__ = [
    "EFFECTS",
    "EffectTable",
    "Effects",
    "FlankModification",
    "FlashTemperature",
    "FreeEdges",
    "Friction",
    "HardnessLaw",
    "LoadLaw",
    "LoadSpectrum",
    "Lubrication",
    "LubricationLaw",
    "Misalignment",
    "Modifications",
    "PitchError",
    "RunLife",
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
class WearLaws:
    """Laws of the wear coefficient: tables under ``[effects.wear_law]``; each present one is a factor."""

    hardness: HardnessLaw | None = None
    lubrication: LubricationLaw | None = None
    temperature: TemperatureLaw | None = None
    load: LoadLaw | None = None


@dataclass(frozen=True, kw_only=True)
class Effects:
    """Table ``[effects]``: every effect of a scene; None stands for an effect that is absent."""

    misalignment: Misalignment | None = None
    modification: Modifications = Modifications()
    free_edges: FreeEdges | None = None
    friction: Friction | None = None
    flash_temperature: FlashTemperature | None = None
    lubrication: Lubrication | None = None
    wear_law: WearLaws = WearLaws()
    load_spectrum: LoadSpectrum | None = None
    pitch_error: PitchError | None = None
    shaft_compliance: ShaftCompliance | None = None
    run_life: RunLife | None = None

    def get(self, name: str) -> EffectTable | None:
        """The table of an effect named as in `EFFECTS`, or None when it is absent.

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
        """Name and table of every effect that is there, in the order of `EFFECTS`."""
        for name in EFFECTS:
            table = self.get(name)
            if table is not None:
                yield name, table


# The dotted name is the one below [effects] in a scene file.
EFFECTS: dict[str, type[EffectTable]] = {
    "misalignment": Misalignment,
    "modification.pinion": FlankModification,
    "modification.gear": FlankModification,
    "free_edges": FreeEdges,
    "friction": Friction,
    "flash_temperature": FlashTemperature,
    "lubrication": Lubrication,
    "wear_law.hardness": HardnessLaw,
    "wear_law.lubrication": LubricationLaw,
    "wear_law.temperature": TemperatureLaw,
    "wear_law.load": LoadLaw,
    "load_spectrum": LoadSpectrum,
    "pitch_error": PitchError,
    "shaft_compliance": ShaftCompliance,
    "run_life": RunLife,
}
