"""Table of flank fracture; exported by `semiwear.scene.effects`."""

from __future__ import annotations

from itertools import pairwise
from typing import ClassVar

from semiwear.scene.declare import declared, table
from semiwear.scene.effect_table import NeedsIf
from semiwear.scene.rating_fields import (
    RatingTable,
    inner_load_factor,
    limit_of_safety,
    outer_load_factor,
    usual_range,
)
from semiwear.scene.rule import Rule, between, choice
from semiwear.scene.values import number, numbers
from semiwear.untyped import Value

_OF_CASE = ("surface_hardness_HV", "case_depth_mm")
_OF_TABLE = ("hardness_depths_mm", "hardness_HV")


def _fields(names: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(f"effects.flank_fracture.{body}_{name}" for body in ("pinion", "gear") for name in names)


def _surface(body: str) -> Value:
    rule = usual_range(551.0, 1000.0, "HV", "650 to 780 case-hardened")
    return declared(rule, f"Vickers hardness of the {body}'s surface.", default=None)


def _core(body: str) -> Value:
    return declared(usual_range(150.0, 549.0, "HV", "300 to 450 case-hardened"), f"Hardness of the {body}'s core.")


def _case_depth(body: str) -> Value:
    rule = usual_range(0.01, 20.0, "mm", "0.15 to 0.3 modules, at 550 HV")
    return declared(rule, f"Case-hardening depth CHD of the {body}'s unworn flank.", default=None)


def _depths(body: str) -> Value:
    def rising(values: tuple[float, ...]) -> bool:
        return len(values) > 1 and values[0] >= 0.0 and all(a < b for a, b in pairwise(values))

    rule = Rule(numbers, "two or more rising depths, 0 mm or more", rising, "depths below the surface in mm, rising")
    return declared(rule, f"Depths of the {body}'s measured hardness.", default=None)


def _hardness(body: str) -> Value:
    def usual(values: tuple[float, ...]) -> bool:
        return all(100.0 <= value <= 1200.0 for value in values)

    rule = Rule(numbers, "100 to 1200 HV each", usual, "Vickers hardness, one for each depth")
    return declared(rule, f"Measured hardness of the {body} at its depths.", default=None)


@table
class FlankFracture(RatingTable):
    """Table ``[effects.flank_fracture]``: safety against fracture that starts below the flank."""

    title: ClassVar[str] = "flank fracture"
    needs_if: ClassVar[NeedsIf] = {
        ("hardness_profile", "case_depth"): _fields(_OF_CASE),
        ("hardness_profile", "table"): _fields(_OF_TABLE),
    }
    validity: ClassVar[str] = "case-hardened steel, from one half-width below the surface on"
    references: ClassVar[tuple[str, ...]] = (
        "Hertter 2003 and Witzig 2012, dissertations, TU Munich (local method behind ISO/TS 6336-4:2019)",
        "Lang 1979 (hardness over depth and residual stress of case-hardened teeth)",
    )

    hardness_profile: str = declared(
        choice("case_depth", "table"),
        "How hardness falls with depth: a curve from surface, core and case depth, or measured.",
        default="case_depth",
    )
    pinion_core_hardness_HV: float = _core("pinion")
    gear_core_hardness_HV: float = _core("gear")
    pinion_surface_hardness_HV: float | None = _surface("pinion")
    gear_surface_hardness_HV: float | None = _surface("gear")
    pinion_case_depth_mm: float | None = _case_depth("pinion")
    gear_case_depth_mm: float | None = _case_depth("gear")
    pinion_hardness_depths_mm: tuple[float, ...] | None = _depths("pinion")
    gear_hardness_depths_mm: tuple[float, ...] | None = _depths("gear")
    pinion_hardness_HV: tuple[float, ...] | None = _hardness("pinion")
    gear_hardness_HV: tuple[float, ...] | None = _hardness("gear")
    material_factor: float = declared(
        between(number, 0.5, 1.5, "K_material: 1 for CrNiMo steels"),
        "K_material: strength at a hardness against that of CrNiMo case-hardening steels.",
        default=1.0,
    )
    application_factor: float = outer_load_factor()
    dynamic_factor: float = inner_load_factor()
    required_safety: float = limit_of_safety("S_FFmin", 1.0)
