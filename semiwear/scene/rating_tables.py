"""Tables of failure modes that are rated over the life; exported by `semiwear.scene.effects`.

Strengths of materials have no defaults, so that a scene that rates a mode must give those of its teeth.
"""

from __future__ import annotations

from typing import ClassVar

from semiwear.scene.declare import declared, table
from semiwear.scene.effect_table import NeedsIf
from semiwear.scene.rating_fields import (
    RatingTable,
    factor,
    inner_load_factor,
    limit_of_safety,
    outer_load_factor,
    usual_above,
    usual_range,
)
from semiwear.scene.rule import Rule, between, choice
from semiwear.scene.values import number
from semiwear.untyped import Value

__all__ = ["Bending", "Pitting", "RatingTable"]

_CONTACT_LIMITS = (
    "usual for sigma_Hlim: 1300 to 1650 case-hardened, 1000 to 1250 nitrided, 500 to 850 through-hardened"
)
_ROOT_LIMITS = "usual for sigma_Flim: 310 to 525 case-hardened, 250 to 470 nitrided, 180 to 370 through-hardened"
_CURVES = "the group of the material, ISO 6336"
_CONTACT_CURVES = ("hardened", "hardened_some_pits", "nitrided", "nitrocarburized")
_ROOT_CURVES = ("case_hardened", "through_hardened", "normalized", "cast_iron", "nitrided", "nitrocarburized")


def _limit(meaning: str, usual: str, high: float) -> Value:
    rule = Rule(number, f"above 0, up to {high:g} MPa; {usual}", lambda value: 0.0 < value <= high, "in MPa (N/mm2)")
    return declared(rule, meaning)


def _curve(body: str, curves: tuple[str, ...]) -> Value:
    return declared(choice(*curves, otherwise=_CURVES), f"Life curve of the {body}'s group of materials.")


def _life_factor() -> Value:
    rule = between(number, 0.85, 1.0, "0.85, up to 1 with best material, manufacture and experience")
    return declared(rule, "Life factor at 1e10 load cycles.", default=0.85)


@table
class Pitting(RatingTable):
    """Table ``[effects.pitting]``: safety against pitting from the local contact pressure."""

    title: ClassVar[str] = "pitting"
    needs_if: ClassVar[NeedsIf] = {
        ("film_factors", "from_oil"): (
            "operation.pinion_speed_rpm",
            "effects.pitting.viscosity_40_mm2_per_s",
            "effects.pitting.roughness_Rz_um",
        ),
        ("film_factors", "given"): ("effects.pitting.film_factor",),
    }
    validity: ClassVar[str] = "lubricated flanks of steel or iron, pressures away from edges"
    references: ClassVar[tuple[str, ...]] = (
        "ISO 6336-2:2019 (surface durability), ISO 6336-5:2016 (strength of materials)",
        "ISO 6336-6:2019 (service life under variable load: Miner's sum)",
    )

    pinion_limit_MPa: float = _limit(
        "Allowable stress number for contact sigma_Hlim of the pinion.", _CONTACT_LIMITS, 5000.0
    )
    gear_limit_MPa: float = _limit(
        "Allowable stress number for contact sigma_Hlim of the gear.", _CONTACT_LIMITS, 5000.0
    )
    pinion_life_curve: str = _curve("pinion", _CONTACT_CURVES)
    gear_life_curve: str = _curve("gear", _CONTACT_CURVES)
    life_factor_at_1e10: float = _life_factor()
    film_factors: str = declared(
        choice("from_oil", "given"),
        "Source of Z_L, Z_v and Z_R: viscosity, speed and roughness, or `film_factor`.",
        default="from_oil",
    )
    film_factor: float | None = declared(
        usual_range(0.5, 1.5, "", "0.85 hobbed, 0.92 to 1 ground"),
        "Z_L Z_v Z_R: influence of oil, speed and roughness.",
        default=None,
    )
    viscosity_40_mm2_per_s: float | None = declared(
        usual_above(10_000.0, "mm2/s", "the oil's ISO VG, 100 to 460"),
        "Kinematic viscosity of the oil at 40 degrees Celsius.",
        default=None,
    )
    roughness_Rz_um: float | None = declared(
        usual_above(100.0, "um", "1 to 6 ground, about 6 Ra"), "Mean Rz of both flanks.", default=None
    )
    gear_work_hardening_factor: float = factor("Z_W", "Work hardening factor Z_W of the gear.", 1.0, 1.2)
    size_factor: float = factor("Z_X", "Size factor Z_X.", 0.5, 1.0)
    application_factor: float = outer_load_factor()
    dynamic_factor: float = inner_load_factor()
    required_safety: float = limit_of_safety("S_Hmin", 1.0)


@table
class Bending(RatingTable):
    """Table ``[effects.bending]``: safety against tooth breakage from the local root stress."""

    title: ClassVar[str] = "tooth root breakage"
    validity: ClassVar[str] = "root stress of compliant teeth (not numerics.tooth_compliance = rigid)"
    references: ClassVar[tuple[str, ...]] = (
        "ISO 6336-3:2019 (tooth bending strength), ISO 6336-5:2016 (strength of materials)",
        "ISO 6336-6:2019 (service life under variable load: Miner's sum)",
    )

    pinion_limit_MPa: float = _limit(
        "Nominal stress number for bending sigma_Flim of the pinion, of test gears with Y_ST = 2.",
        _ROOT_LIMITS,
        2000.0,
    )
    gear_limit_MPa: float = _limit(
        "Nominal stress number for bending sigma_Flim of the gear, of test gears with Y_ST = 2.", _ROOT_LIMITS, 2000.0
    )
    pinion_life_curve: str = _curve("pinion", _ROOT_CURVES)
    gear_life_curve: str = _curve("gear", _ROOT_CURVES)
    life_factor_at_1e10: float = _life_factor()
    root_roughness_Rz_um: float = declared(
        usual_above(40.0, "um", "5 to 20 in a fillet, about 6 Ra"),
        "Rz of the root fillets.",
    )
    notch_sensitivity_factor: float = factor(
        "Y_delta_relT", "Relative notch sensitivity factor Y_delta_relT; about 1 for usual fillets.", 0.5, 1.5
    )
    size_factor: float | None = declared(
        between(number, 0.5, 1.0, "Y_X; 1 up to a module of 5 mm"),
        "Size factor Y_X. Left out: from the module.",
        default=None,
    )
    mean_stress_factor: float = factor(
        "Y_M", "Mean stress factor Y_M: 0.7 for teeth loaded in both directions.", 0.3, 1.0
    )
    application_factor: float = outer_load_factor()
    dynamic_factor: float = inner_load_factor()
    required_safety: float = limit_of_safety("S_Fmin", 1.4)
