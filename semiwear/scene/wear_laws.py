"""Tables under ``[effects.wear_law]``, laws of the wear coefficient; exported by `semiwear.scene.effects`.

The laws themselves have the same names in `semiwear.wear.laws`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from semiwear.scene.declare import declared, table
from semiwear.scene.effect_table import EffectTable
from semiwear.scene.rule import above, at_least_zero, between, positive
from semiwear.scene.values import number
from semiwear.untyped import Value

_HARDNESS = "Vickers hardness: about 700 for a case, 300 to 450 for a core; 60 HRC is 697 HV"
_TEMPERATURE = "in degrees Celsius: 60 to 120 is usual"


def _hardness(meaning: str, default: float | None) -> Value:
    return declared(between(number, 50.0, 2000.0, _HARDNESS, "HV"), meaning, default=default)


@table
class HardnessLaw(EffectTable):
    """Table ``[effects.wear_law.hardness]``: wear is inversely proportional to the hardness at the worn depth."""

    title: ClassVar[str] = "wear by hardness"
    acts_in: ClassVar[str] = "wear"
    needs: ClassVar[tuple[str, ...]] = ("wear",)
    validity: ClassVar[str] = "mild wear; the wear coefficient of [wear] is that of the surface hardness"
    references: ClassVar[tuple[str, ...]] = (
        "Archard 1953, Contact and rubbing of flat surfaces (wear over hardness)",
    )

    surface_hardness_HV: float = _hardness("Hardness of the case.", 700.0)
    core_hardness_HV: float = _hardness("Hardness of the core.", 400.0)
    case_depth_um: float = declared(
        above(0.0, 10_000.0, "in um: nitrided cases are 30 to 600 deep", "um"),
        "Depth of the middle of the transition from case to core.",
        default=30.0,
    )
    transition_um: float = declared(
        at_least_zero("0 for a sharp step from case to core", "um"),
        "Width over which hardness passes linearly from case to core; 0 is a sharp step.",
        default=0.0,
    )
    pitch_hardness_HV: float | None = _hardness(
        "Hardness of the surface within a band about the pitch line; left out: as elsewhere.", None
    )
    pitch_band_mm: float = declared(
        positive("half the width of the band about the pitch line"), "Half-width of that band.", default=2.0
    )


@table
class LubricationLaw(EffectTable):
    """Table ``[effects.wear_law.lubrication]``: wear decreases linearly with the lambda ratio."""

    title: ClassVar[str] = "wear by oil film"
    acts_in: ClassVar[str] = "wear"
    needs: ClassVar[tuple[str, ...]] = ("wear", "effects.lubrication")
    validity: ClassVar[str] = "mixed lubrication; the wear coefficient of [wear] is that of boundary lubrication"
    references: ClassVar[tuple[str, ...]] = (
        "Priest and Taylor 2000, Wear 241, 193-203 (wear coefficient, linear in the film ratio)",
    )

    boundary_lambda: float = declared(
        above(0.0, 100.0, "film thickness over roughness: 0.5 is usual"),
        "Film thickness over roughness up to which the wear coefficient is that of ``[wear]``.",
        default=0.5,
    )
    full_film_lambda: float = declared(
        above(0.0, 100.0, "film thickness over roughness: 3 to 4 is usual"),
        "Film thickness over roughness from which the film carries all load.",
        default=4.0,
    )
    strength: float = declared(
        between(number, 0.0, 1.0, "the share of wear that a full film prevents: 1 for all of it"),
        "Share of wear that a full film prevents, 0 to 1.",
        default=1.0,
    )


@table
class TemperatureLaw(EffectTable):
    """Table ``[effects.wear_law.temperature]``: the wear coefficient rises with temperature, after Arrhenius."""

    title: ClassVar[str] = "wear by temperature"
    acts_in: ClassVar[str] = "wear"
    needs: ClassVar[tuple[str, ...]] = ("wear", "effects.flash_temperature")
    validity: ClassVar[str] = "mild wear governed by one thermally activated process; below scuffing"
    references: ClassVar[tuple[str, ...]] = (
        "Arrhenius 1889, Z. Phys. Chem. 4, 226-248 (rate against temperature)",
        "Quinn 1983, Tribology International 16, 257-271 (oxidative wear)",
    )

    activation_energy_kJ_per_mol: float = declared(
        between(number, 0.0, 1000.0, "in kJ/mol: 10 to 100 is usual", "kJ/mol"), "Activation energy.", default=20.0
    )
    reference_temperature_C: float = declared(
        between(number, -60.0, 400.0, _TEMPERATURE, "degrees Celsius"),
        "Temperature at which the wear coefficient is that of ``[wear]``.",
        default=80.0,
    )


@table
class LoadLaw(EffectTable):
    """Table ``[effects.wear_law.load]``: the wear coefficient is a power of contact pressure."""

    title: ClassVar[str] = "wear by pressure"
    acts_in: ClassVar[str] = "wear"
    needs: ClassVar[tuple[str, ...]] = ("wear",)
    validity: ClassVar[str] = "pressures near those at which the exponent was measured"
    references: ClassVar[tuple[str, ...]] = ("Rhee 1970, Wear 16, 431-445 (wear as a power of load)",)

    exponent: float = declared(
        between(number, -2.0, 4.0, "0 is Archard's law; 0.5 to 1 is usual where load makes wear worse"),
        "k is proportional to (pressure / reference pressure) ** exponent. With an exponent below 0 it is constant "
        "below a hundredth of the reference pressure.",
        default=0.5,
    )
    reference_pressure_MPa: float = declared(
        above(0.0, 10_000.0, "in MPa: the pressure of the test that gave the coefficient", "MPa"),
        "Pressure at which the wear coefficient is that of ``[wear]``.",
        default=1000.0,
    )


@dataclass(frozen=True, kw_only=True)
class WearLaws:
    """Laws of the wear coefficient: tables under ``[effects.wear_law]``; each present table is a factor."""

    hardness: HardnessLaw | None = None
    lubrication: LubricationLaw | None = None
    temperature: TemperatureLaw | None = None
    load: LoadLaw | None = None
