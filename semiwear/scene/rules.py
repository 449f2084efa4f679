"""What each field of a scene may hold: one line a field, in the order in which a scene is written."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import pairwise
from typing import Any

from semiwear.scene.closest import closest
from semiwear.scene.effect_rules import EFFECT_RULES
from semiwear.scene.rule import Rule, advice, anything, at_least_zero, auto_or, between, choice, positive
from semiwear.scene.tables import BODIES, BodyCoefficients
from semiwear.scene.values import Unreadable, number, numbers, shown, text, texts, whole

__all__ = ["RULES", "USUAL_WEAR_COEFFICIENTS", "Rule"]

_COEFFICIENTS = "a table {pinion = ..., gear = ...}"


def _edge_radius() -> Rule:
    return at_least_zero("give 0 for a sharp edge, or leave the field out for a deburred one")


def _youngs_modulus() -> Rule:
    """From soft polymers to diamond, which tells the units apart."""

    def fix(value: float) -> str:
        for unit, factor in (("GPa", 1e3), ("Pa", 1e-6)):
            if 0.5e3 <= factor * value <= 1.5e6:
                return f"this looks like {unit}: give {factor * value:g}; 207000 for steel"
        return "in MPa: 207000 for steel"

    return Rule(number, "500 to 1500000 MPa", lambda value: 500.0 <= value <= 1.5e6, fix)


def _increasing_depths() -> Rule:
    def holds(depths: tuple[float, ...]) -> bool:
        return bool(depths) and depths[0] > 0.0 and all(a < b for a, b in pairwise(depths))

    def fix(depths: tuple[float, ...]) -> str:
        kept = sorted({depth for depth in depths if depth > 0.0})
        return f"give {[float(f'{depth:.6g}') for depth in kept]}" if kept else "give e.g. [5, 10, 15]"

    return Rule(numbers, "one or more depths in um, above 0 and strictly increasing", holds, fix)


def _bodies(raw: Any) -> tuple[str, ...]:
    """A list of texts, the pinion first where it holds nothing but bodies."""
    bodies = texts(raw)
    return tuple(sorted(bodies, key=BODIES.index)) if set(bodies) <= set(BODIES) else bodies


def _worn_bodies() -> Rule:
    def holds(bodies: tuple[str, ...]) -> bool:
        return bool(bodies) and set(bodies) <= set(BODIES) and len(set(bodies)) == len(bodies)

    def fix(bodies: tuple[str, ...]) -> str:
        if not bodies:
            return 'give ["gear"]; for loaded contact without wear remove [wear]'
        meant = {body if body in BODIES else closest(body, BODIES) for body in bodies[:10]} - {None}
        return f"give {_listed(body for body in BODIES if body in meant)}" if meant else 'give ["gear"]'

    return Rule(_bodies, '["gear"] or ["pinion"] or ["pinion", "gear"]', holds, fix)


def _listed(words: Iterable[str]) -> str:
    return "[" + ", ".join(f'"{word}"' for word in words) + "]"


def _coefficient(raw: Any) -> float | BodyCoefficients:
    if isinstance(raw, BodyCoefficients):
        raw = {body: value for body in BODIES if (value := getattr(raw, body)) is not None}
    if not isinstance(raw, Mapping):
        return number(raw)
    raw = {body: value for body, value in raw.items() if value is not None}
    foreign = [name for name in raw if name not in BODIES]
    if foreign or not raw:
        raise Unreadable(f"give {_COEFFICIENTS}{f', not {shown(foreign[0])}' if foreign else ''}")
    try:
        return BodyCoefficients(**{body: number(value) for body, value in raw.items()})
    except Unreadable as reason:
        raise Unreadable(f"of each body {reason}") from None


def _each(value: float | BodyCoefficients) -> tuple[float, ...]:
    """The coefficients that are given."""
    if not isinstance(value, BodyCoefficients):
        return (value,)
    return tuple(one for one in (value.pinion, value.gear) if one is not None)


_WEAR_COEFFICIENTS = (1e-16, 1e-5)
"""Of any sliding pair [mm2/N]. Archard's number K = k times hardness is 1e-8 to 1e-2 for metals (Archard and Hirst
1956), which at 200 to 10,000 MPa makes k 1e-12 to 5e-5; lubricated gears go down to 1e-13 (Andersson and Flodin)."""

USUAL_WEAR_COEFFICIENTS = (1e-14, 1e-7)
"""From well lubricated hard steel to dry plastics [mm2/N]; beyond, a unit has probably slipped."""

_USUAL_COEFFICIENT = "1e-13 to 1e-9 mm2/N is usual of lubricated steel, 1e-9 to 1e-7 of plastics"


def _wear_coefficient() -> Rule:
    least, most = _WEAR_COEFFICIENTS

    def holds(value: float | BodyCoefficients) -> bool:
        return all(least <= one <= most for one in _each(value))

    def fix(value: float | BodyCoefficients) -> str:
        wrong = next(one for one in _each(value) if not least <= one <= most)
        if wrong <= 0.0:
            return f"give a positive number: {_USUAL_COEFFICIENT}"
        if wrong < least:
            return f"{wrong:g} looks like m2/N: give {1e6 * wrong:g}; {_USUAL_COEFFICIENT}"
        return f"{wrong:g} looks like Archard's number: divide it by the hardness in MPa; {_USUAL_COEFFICIENT}"

    least, most = _WEAR_COEFFICIENTS
    allowed = f"{least:g} to {most:g} mm2/N, or {_COEFFICIENTS}"
    return Rule(_coefficient, allowed, holds, fix)


def _tooth_compliance() -> Rule:
    words = ("prism", "rigid")

    def fix(value: str) -> str:
        meant = closest(value, words)
        return f'did you mean "{meant}"?' if meant else 'give "prism", or a file that ends with .nc'

    allowed = '"prism" or "rigid" or a netCDF file of influence data'

    def is_file(value: str) -> bool:
        return value not in words

    return Rule(text, allowed, lambda value: value in words or value.endswith(".nc"), fix, is_file)


def _pair(**rules: Rule) -> dict[str, Rule]:
    return {f"gear_pair.{name}": rule for name, rule in rules.items()}


def _numerics(**rules: Rule) -> dict[str, Rule]:
    return {f"numerics.{name}": rule for name, rule in rules.items()}


def _material(body: str) -> dict[str, Rule]:
    return {
        f"material.{body}.name": anything(),
        f"material.{body}.youngs_modulus_MPa": _youngs_modulus(),
        f"material.{body}.poissons_ratio": Rule(
            number, "above 0 and below 0.5", lambda value: 0.0 < value < 0.5, advice("0.3 for steel")
        ),
    }


_TEETH = "count the teeth of the whole gear"
_CUTTER_TIP = "leave the field out for its default, which grows with the module"
_LENGTH = "a length, or leave the field out for its default"
_RADIUS = "a radius from the gear axis; the teeth lie around the pitch radius m z2/2"

# The upper limits of whole numbers are far beyond use; they keep slips from exhausting memory.
RULES: dict[str, Rule] = {
    "title": anything(),
    "reference": choice("seed_paper", otherwise="leave the field out when there is nothing to compare with"),
    **_pair(
        type=choice("face_gear", "cylindrical", "flank_points"),
        pinion_teeth=between(whole, 12, 1000, _TEETH),
        shaper_teeth=between(whole, 12, 1000, _TEETH),
        gear_teeth=between(whole, 12, 1000, _TEETH),
        module_mm=positive("the module is the pitch diameter divided by the number of teeth"),
        pressure_angle_deg=between(number, 10.0, 35.0, "in degrees: 20 and 25 are usual", "degrees"),
        gear_inner_radius_mm=positive(_RADIUS),
        gear_outer_radius_mm=positive(_RADIUS),
        pinion_face_width_mm=positive("usually about the gear's outer less its inner radius"),
        shaft_angle_deg=Rule(number, "90 degrees", lambda value: value == 90.0, advice("not available yet; only 90")),
        pinion_centre_mm=positive("distance of the middle of the pinion's face width from the gear axis"),
        pinion_addendum_mm=positive(_LENGTH),
        gear_addendum_mm=positive(_LENGTH),
        shaper_addendum_mm=positive(_LENGTH),
        rack_addendum_mm=positive(_LENGTH),
        shaper_tip_radius_mm=at_least_zero(_CUTTER_TIP),
        rack_tip_radius_mm=at_least_zero(_CUTTER_TIP),
        pinion_tip_edge_radius_mm=_edge_radius(),
        gear_tip_edge_radius_mm=_edge_radius(),
        pinion_end_edge_radius_mm=_edge_radius(),
        gear_end_edge_radius_mm=_edge_radius(),
        pinion_bore_radius_mm=positive(_LENGTH),
        gear_rim_thickness_mm=positive(_LENGTH),
    ),
    **_material("pinion"),
    **_material("gear"),
    "operation.pinion_torque_Nm": positive(
        'give its size; for the other flank set operation.loaded_flank = "coast"', "N m"
    ),
    "operation.loaded_flank": choice("drive", "coast"),
    "operation.pinion_speed_rpm": positive("the pinion's speed in rev/min, without a sign", "rev/min"),
    "wear.coefficient_mm2_per_N": _wear_coefficient(),
    "wear.worn_bodies": _worn_bodies(),
    "wear.until.meshes": positive("number of engagements of one gear tooth", ""),
    "wear.until.control_depths_um": _increasing_depths(),
    "wear.control_point.radius_mm": positive("gear radius of the control point"),
    "wear.control_point.height_mm": Rule(number, "a number of mm", lambda value: True, advice("")),
    "wear.control_point.body": choice(*BODIES),
    **_numerics(
        accuracy=between(number, 1e-4, 0.5, "0.02 is usual: 2 % of the greatest value of each kind"),
        fidelity=choice("line", "patch"),
        wear_mapping=choice("interpolated", "marched"),
        wear_scheme=choice("implicit", "two-stage", "explicit"),
        wear_steps=auto_or(1, 10_000, 'give "auto"'),
        roll_positions=between(whole, 8, 10_000, "24 is usual"),
        face_slices=between(whole, 7, 10_000, "61 is usual"),
        cells_per_half_width=between(whole, 2, 1000, "8 is usual"),
        profile_points=between(whole, 21, 10_000, "141 is usual"),
        tooth_pairs=auto_or(1, 7, 'give "auto"'),
        tooth_compliance=_tooth_compliance(),
        harmonics=between(whole, 1, 1000, "33 is usual"),
        max_iterations=between(whole, 1, 1_000_000, "60 is usual"),
    ),
    **EFFECT_RULES,
}
