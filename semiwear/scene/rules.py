"""What each field of a scene may hold: one line a field, in the order in which a scene is written."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from semiwear.errors import Problem
from semiwear.scene.closest import closest
from semiwear.scene.values import (
    Reader,
    Unreadable,
    number,
    numbers,
    shown,
    text,
    texts,
    whole,
    whole_or_auto,
)

__all__ = ["RULES", "Rule"]


@dataclass(frozen=True)
class Rule:
    """The allowed values of one field.

    Attributes
    ----------
    read : callable
        From the raw value to the value kept; raises `Unreadable` for a wrong type.
    allowed : str
        The allowed range in words.
    holds : callable
        Whether a value that could be read is in that range.
    fix : callable
        From a value out of range to the likely remedy.
    """

    read: Reader
    allowed: str
    holds: Callable[[Any], bool]
    fix: Callable[[Any], str]

    def apply(self, key: str, raw: Any) -> tuple[Any, Problem | None]:
        """The value to keep (None if there is a problem), and the problem if there is one."""
        try:
            value = self.read(raw)
        except Unreadable as reason:
            return None, Problem(key, shown(raw), self.allowed, str(reason))
        if self.holds(value):
            return value, None
        return None, Problem(key, shown(raw), self.allowed, self.fix(value))


def _advice(fix: str) -> Callable[[Any], str]:
    return lambda value: fix


def _positive(fix: str, unit: str = "mm") -> Rule:
    return Rule(number, f"greater than 0 {unit}".rstrip(), lambda value: value > 0.0, _advice(fix))


def _edge_radius() -> Rule:
    fix = "give 0 for a sharp edge, 0.2 for a deburred one"
    return Rule(number, "0 mm or more", lambda value: value >= 0.0, _advice(fix))


def _between(read: Reader, low: float, high: float, fix: str, unit: str = "") -> Rule:
    allowed = f"{'whole number, ' if read is whole else ''}{low:g} to {high:g} {unit}".rstrip()
    return Rule(read, allowed, lambda value: low <= value <= high, _advice(fix))


def _auto_or(low: int, high: int, fix: str) -> Rule:
    def holds(value: int | str) -> bool:
        return value == "auto" or (isinstance(value, int) and low <= value <= high)

    return Rule(whole_or_auto, f'"auto" or a whole number, {low} to {high}', holds, _advice(fix))


def _choice(*options: str, otherwise: str = "") -> Rule:
    """One of a few words."""
    allowed = " or ".join(f'"{option}"' for option in options)

    def fix(value: str) -> str:
        meant = closest(value, options)
        if meant is not None:
            return f'did you mean "{meant}"?'
        return otherwise or f'give "{options[0]}"'

    return Rule(text, allowed, lambda value: value in options, fix)


def _anything() -> Rule:
    return Rule(text, "text", lambda value: True, _advice(""))


def _increasing_depths() -> Rule:
    def holds(depths: tuple[float, ...]) -> bool:
        return bool(depths) and depths[0] > 0.0 and all(a < b for a, b in pairwise(depths))

    def fix(depths: tuple[float, ...]) -> str:
        kept = sorted({depth for depth in depths if depth > 0.0})
        return f"give {[float(f'{depth:.6g}') for depth in kept]}" if kept else "give e.g. [5, 10, 15]"

    return Rule(numbers, "one or more depths in um, above 0 and strictly increasing", holds, fix)


def _worn_bodies() -> Rule:
    def fix(bodies: tuple[str, ...]) -> str:
        if "pinion" in bodies:
            return 'pinion wear is not available yet: give ["gear"]'
        return 'give ["gear"], or leave the field out'

    return Rule(texts, '["gear"]', lambda bodies: bodies == ("gear",), fix)


def _tooth_compliance() -> Rule:
    words = ("prism", "rigid")

    def fix(value: str) -> str:
        meant = closest(value, words)
        return f'did you mean "{meant}"?' if meant else 'give "prism", or a file that ends with .nc'

    allowed = '"prism" or "rigid" or a netCDF file of influence data'
    return Rule(text, allowed, lambda value: value in words or value.endswith(".nc"), fix)


def _pair(**rules: Rule) -> dict[str, Rule]:
    return {f"gear_pair.{name}": rule for name, rule in rules.items()}


def _numerics(**rules: Rule) -> dict[str, Rule]:
    return {f"numerics.{name}": rule for name, rule in rules.items()}


def _material(body: str) -> dict[str, Rule]:
    return {
        f"material.{body}.name": _anything(),
        f"material.{body}.youngs_modulus_MPa": _positive("in MPa: 207000 for steel", "MPa"),
        f"material.{body}.poissons_ratio": Rule(
            number, "above 0 and below 0.5", lambda value: 0.0 < value < 0.5, _advice("0.3 for steel")
        ),
    }


_TEETH = "count the teeth of the whole gear"
_CUTTER_TIP = "leave the field out for its default, which grows with the module"
_LENGTH = "a length, or leave the field out for its default"
_RADIUS = "a radius from the gear axis; the teeth lie around the pitch radius m z2/2"

# The upper limits of whole numbers are far beyond use; they keep slips from exhausting memory.
RULES: dict[str, Rule] = {
    "title": _anything(),
    "reference": _choice("seed_paper", otherwise="leave the field out when there is nothing to compare with"),
    **_pair(
        type=_choice("face_gear"),
        pinion_teeth=_between(whole, 12, 1000, _TEETH),
        shaper_teeth=_between(whole, 12, 1000, _TEETH),
        gear_teeth=_between(whole, 12, 1000, _TEETH),
        module_mm=_positive("the module is the pitch diameter divided by the number of teeth"),
        pressure_angle_deg=_between(number, 10.0, 35.0, "in degrees: 20 and 25 are usual", "degrees"),
        gear_inner_radius_mm=_positive(_RADIUS),
        gear_outer_radius_mm=_positive(_RADIUS),
        pinion_face_width_mm=_positive("usually about the gear's outer less its inner radius"),
        shaft_angle_deg=Rule(
            number, "90 degrees", lambda value: value == 90.0, _advice("not available yet; only 90")
        ),
        pinion_centre_mm=_positive("distance of the middle of the pinion's face width from the gear axis"),
        pinion_addendum_mm=_positive(_LENGTH),
        gear_addendum_mm=_positive(_LENGTH),
        shaper_addendum_mm=_positive(_LENGTH),
        rack_addendum_mm=_positive(_LENGTH),
        shaper_tip_radius_mm=Rule(number, "0 mm or more", lambda value: value >= 0.0, _advice(_CUTTER_TIP)),
        rack_tip_radius_mm=Rule(number, "0 mm or more", lambda value: value >= 0.0, _advice(_CUTTER_TIP)),
        pinion_tip_edge_radius_mm=_edge_radius(),
        gear_tip_edge_radius_mm=_edge_radius(),
        pinion_end_edge_radius_mm=_edge_radius(),
        gear_end_edge_radius_mm=_edge_radius(),
        pinion_bore_radius_mm=_positive(_LENGTH),
        gear_rim_thickness_mm=_positive(_LENGTH),
    ),
    **_material("pinion"),
    **_material("gear"),
    "operation.pinion_torque_Nm": _positive(
        'give its size; for the other flank set operation.loaded_flank = "coast"', "N m"
    ),
    "operation.loaded_flank": _choice("drive", "coast"),
    "wear.coefficient_mm2_per_N": _positive("1e-13 is typical of hard, lubricated steel", "mm2/N"),
    "wear.worn_bodies": _worn_bodies(),
    "wear.until.meshes": _positive("number of engagements of one gear tooth", ""),
    "wear.until.control_depths_um": _increasing_depths(),
    "wear.control_point.radius_mm": _positive("gear radius of the control point"),
    "wear.control_point.height_mm": Rule(number, "a number of mm", lambda value: True, _advice("")),
    **_numerics(
        fidelity=_choice("line", "patch"),
        wear_mapping=_choice("interpolated", "marched"),
        wear_scheme=_choice("implicit", "explicit"),
        wear_steps=_auto_or(1, 10_000, 'give "auto"'),
        roll_positions=_between(whole, 8, 10_000, "24 is usual"),
        face_slices=_between(whole, 7, 10_000, "61 is usual"),
        cells_per_half_width=_between(whole, 2, 1000, "8 is usual"),
        profile_points=_between(whole, 21, 10_000, "141 is usual"),
        tooth_pairs=_auto_or(1, 7, 'give "auto"'),
        tooth_compliance=_tooth_compliance(),
        harmonics=_between(whole, 1, 1000, "33 is usual"),
        max_iterations=_between(whole, 1, 1_000_000, "60 is usual"),
    ),
}
