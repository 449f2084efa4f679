"""Tables of the failure modes of the oil film, micropitting and scuffing; exported by `semiwear.scene.effects`.

Properties and test results of the oil have no defaults, nor have the strengths of materials in other modes.
"""

from __future__ import annotations

from typing import ClassVar

from semiwear.scene.declare import declared, table
from semiwear.scene.effect_table import NeedsIf
from semiwear.scene.rating_fields import (
    RatingTable,
    inner_load_factor,
    limit_of_safety,
    outer_load_factor,
    usual_above,
    usual_range,
)
from semiwear.scene.rule import between, choice
from semiwear.scene.values import number
from semiwear.untyped import Value

_NEEDS = ("wear", "operation.pinion_speed_rpm", "effects.flash_temperature")


def _needed(meaning: str, low: float, high: float, unit: str, usual: str) -> Value:
    return declared(usual_range(low, high, unit, usual), meaning)


def _temperature(meaning: str, usual: str) -> Value:
    return _needed(meaning, -60.0, 250.0, "degrees Celsius", usual)


@table
class OilTable(RatingTable):
    """Fields of the oil common to these tables."""

    oil_family: str = declared(
        choice("mineral", "polyalphaolefin", "polyglycol", otherwise="the base oil of its data sheet"),
        "Family of the oil.",
    )
    viscosity_40_mm2_per_s: float = _needed(
        "Kinematic viscosity of the oil at 40 degrees Celsius.", 2.0, 10_000.0, "mm2/s", "its ISO VG, 100 to 460"
    )
    viscosity_100_mm2_per_s: float = _needed(
        "Kinematic viscosity of the oil at 100 degrees Celsius.",
        1.0,
        1000.0,
        "mm2/s",
        "11 to 35, of a mineral VG 220 about 19",
    )
    density_15_kg_per_m3: float = _needed(
        "Density of the oil at 15 degrees Celsius.", 700.0, 1200.0, "kg/m3", "840 to 910, of polyglycols 1000 to 1100"
    )
    application_factor: float = outer_load_factor()
    dynamic_factor: float = inner_load_factor()


@table
class Micropitting(OilTable):
    """Table ``[effects.micropitting]``: safety of the oil film against grey staining."""

    title: ClassVar[str] = "micropitting"
    needs: ClassVar[tuple[str, ...]] = _NEEDS
    needs_if: ClassVar[NeedsIf] = {
        ("limit", "load_stage"): ("effects.micropitting.load_stage",),
        ("limit", "given"): ("effects.micropitting.permissible_film",),
    }
    validity: ClassVar[str] = "flooded contacts of case-hardened steel, Ra near the 0.5 um of the test gears"
    references: ClassVar[tuple[str, ...]] = (
        "ISO/TS 6336-22:2018, formerly ISO/TR 15144-1:2014 (local method), as an open program quotes it",
        "FVA 1993, information sheet 54/7 (micropitting test C-GF/8,3/90)",
    )

    bulk_temperature_C: float = _temperature("Bulk temperature of the teeth before they mesh.", "60 to 120")
    roughness_Ra_um: float = _needed("Mean Ra of both flanks.", 0.01, 10.0, "um", "0.2 to 0.8 ground, about Rz/6")
    limit: str = declared(
        choice("load_stage", "given"),
        "Source of the permissible film: the oil's `load_stage`, or `permissible_film`.",
        default="load_stage",
    )
    load_stage: float | None = declared(
        usual_range(5.0, 10.0, "", "8 to 10, from the oil's data sheet (C-GF/8,3/90, no other test)"),
        "Failure load stage of the oil in the micropitting test C-GF/8,3/90.",
        default=None,
    )
    permissible_film: float | None = declared(
        usual_above(5.0, "", "0.05 to 0.6"),
        "Permissible specific film lambda_GFP.",
        default=None,
    )
    material_factor: float = declared(
        between(number, 0.5, 2.0, "W_W: 1 for case-hardened steel as in the test"),
        "Material factor W_W for flanks of another steel than the case-hardened steel of the test.",
        default=1.0,
    )
    required_safety: float = limit_of_safety("S_lambda_min", 1.0)


@table
class Scuffing(OilTable):
    """Table ``[effects.scuffing]``: safety against scuffing from the contact temperature."""

    title: ClassVar[str] = "scuffing"
    needs: ClassVar[tuple[str, ...]] = _NEEDS
    validity: ClassVar[str] = "oil-lubricated steel, pitch-line speeds of 1 to 50 m/s"
    references: ClassVar[tuple[str, ...]] = (
        "ISO/TS 6336-20, formerly ISO/TR 13989-1:2000 (flash temperature method), as an open program quotes it",
        "ISO/TS 6336-21, formerly ISO/TR 13989-2:2000 (integral temperature method), as an open program quotes it",
    )

    method: str = declared(
        choice("flash_temperature", "integral_temperature"),
        "The greatest contact temperature against its limit, or the mean along the path of contact.",
        default="flash_temperature",
    )
    oil_temperature_C: float = _temperature("Temperature of the oil in the sump or at the nozzle.", "40 to 90")
    oil_supply: str = declared(
        choice("dip", "spray", "submerged", otherwise="the kind of oil supply to the mesh"),
        "Kind of oil supply to the mesh, which cools the teeth.",
    )
    load_stage: float = _needed(
        "Failure load stage of the oil in the FZG test A/8,3/90.", 1.0, 14.0, "", "8 to 13, from its data sheet"
    )
    structural_factor: float = _needed(
        "Structural (welding) factor X_W of the flanks, the lower of both.",
        0.4,
        1.6,
        "",
        "X_W 1 case-hardened, 1.25 phosphated, 1.5 nitrided, 0.45 stainless",
    )
    required_safety: float = limit_of_safety("S_Smin", 2.0)
