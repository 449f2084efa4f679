"""Rules over several fields that need no tooth geometry; each names its fields."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

from semiwear.errors import Problem
from semiwear.scene.across import RuleBook, across
from semiwear.scene.defaults import full_round_radius
from semiwear.scene.rules import BODIES, BodyCoefficients
from semiwear.scene.tables import default_watched_body
from semiwear.scene.values import shown

CROSS_RULES: RuleBook = []
_across = partial(across, CROSS_RULES)
_KINDS = {"seed_paper": "face_gear"}


@_across("", "reference", "gear_pair.type")
def _reference_is_of_the_kind(reference: str | None, kind: str) -> Iterator[Problem]:
    if reference is not None and kind != _KINDS[reference]:
        yield Problem(
            "reference",
            reference,
            f'none for gear_pair.type = "{kind}"',
            f'remove it: its figures are of gear_pair.type = "{_KINDS[reference]}"',
        )


def mm(length: float) -> str:
    """A length in a message."""
    return f"{length:.6g}"


@_across("gear_pair", "pinion_teeth", "shaper_teeth")
def _shaper_exceeds_pinion(pinion_teeth: int, shaper_teeth: int) -> Iterator[Problem]:
    if shaper_teeth <= pinion_teeth:
        yield Problem(
            "gear_pair.shaper_teeth",
            shaper_teeth,
            f"more than pinion_teeth ({pinion_teeth})",
            "the contact is localised, and tolerates mounting errors, only if the shaper has a few teeth more "
            f"than the pinion, usually 1 to 3: give {pinion_teeth + 1} to {pinion_teeth + 3}",
        )


@_across("gear_pair", "module_mm", "gear_teeth", "gear_inner_radius_mm", "gear_outer_radius_mm")
def _pitch_point_lies_in_the_face(module: float, gear_teeth: int, inner: float, outer: float) -> Iterator[Problem]:
    pitch_radius = 0.5 * module * gear_teeth
    if outer <= inner:
        fix = f"swap them: {mm(outer)} and {mm(inner)}" if outer < pitch_radius < inner else "give radii"
        allowed = f"greater than gear_inner_radius_mm ({mm(inner)} mm)"
        yield Problem("gear_pair.gear_outer_radius_mm", outer, allowed, fix)
        return
    if inner < pitch_radius < outer:
        return
    pitch = f"the pitch radius is {mm(pitch_radius)} mm"
    scaled = True
    if inner / 2 < pitch_radius < outer / 2:
        fix = f"these look like diameters: {pitch}; give {mm(inner / 2)} and {mm(outer / 2)}"
    elif inner * 2 < pitch_radius < outer * 2:
        fix = (
            f"these look like halved radii (the paper calls its radii diameters): {pitch}; "
            f"give {mm(inner * 2)} and {mm(outer * 2)}"
        )
    else:
        scaled = False
        fix = f"{pitch} (module times gear_teeth / 2): correct the radii, the module or the teeth"
    # Both radii need the correction if both were scaled, although only one is on the wrong side.
    if scaled or inner >= pitch_radius:
        allowed = f"below the pitch radius ({mm(pitch_radius)} mm)"
        yield Problem("gear_pair.gear_inner_radius_mm", inner, allowed, fix)
    if scaled or outer <= pitch_radius:
        allowed = f"above the pitch radius ({mm(pitch_radius)} mm)"
        yield Problem("gear_pair.gear_outer_radius_mm", outer, allowed, fix)


@_across(
    "gear_pair",
    "module_mm",
    "gear_teeth",
    "pinion_face_width_mm",
    "pinion_centre_mm",
    "gear_inner_radius_mm",
    "gear_outer_radius_mm",
)
def _pinion_covers_the_pitch_point(
    module: float, gear_teeth: int, width: float, centre: float, inner: float, outer: float
) -> Iterator[Problem]:
    pitch_radius = 0.5 * module * gear_teeth
    if abs(centre - pitch_radius) < width / 2:
        return
    low, high = pitch_radius - width / 2, pitch_radius + width / 2
    middle = (inner + outer) / 2
    if abs(middle - pitch_radius) < width / 2:
        fix = f"give {mm(middle)}, the middle of the gear's face"
    else:
        fix = f"give {mm(pitch_radius)}, or a wider pinion"
    allowed = f"{mm(low)} to {mm(high)} mm: the pinion's face must cover the pitch radius"
    yield Problem("gear_pair.pinion_centre_mm", centre, allowed, fix)


for _body, _other, _cutter in (("pinion", "gear", "shaper"), ("gear", "pinion", "rack")):

    @_across("gear_pair", f"{_body}_addendum_mm", f"{_cutter}_addendum_mm")
    def _root_is_clear(
        addendum: float, dedendum: float, body: str = _body, other: str = _other, cutter: str = _cutter
    ) -> Iterator[Problem]:
        if addendum >= dedendum:
            allowed = f"less than {cutter}_addendum_mm ({mm(dedendum)} mm)"
            fix = f"the {body}'s tips need bottom clearance in the {other}'s roots, usually 0.25 modules"
            yield Problem(f"gear_pair.{body}_addendum_mm", addendum, allowed, fix)


@_across("gear_pair", "module_mm", "pressure_angle_deg", "rack_addendum_mm", "rack_tip_radius_mm")
def _rack_crest_can_be_rounded(
    module: float, pressure_angle_deg: float, addendum: float, tip_radius: float
) -> Iterator[Problem]:
    full = full_round_radius(module, pressure_angle_deg, addendum)
    if full < 0.0:
        greatest = math.pi * module / 4 / math.tan(math.radians(pressure_angle_deg))
        fix = "the rack's flanks cross below its crest: lower the addendum or the pressure angle"
        yield Problem("gear_pair.rack_addendum_mm", addendum, f"up to {mm(greatest)} mm", fix)
    elif tip_radius > full:
        fix = f"the crest is fully round at {mm(full)} mm: give less, or lower rack_addendum_mm"
        yield Problem("gear_pair.rack_tip_radius_mm", tip_radius, f"0 to {mm(full)} mm", fix)


@_across("gear_pair", "module_mm", "pinion_teeth", "rack_addendum_mm", "pinion_bore_radius_mm")
def _pinion_has_a_rim(module: float, pinion_teeth: int, rack_addendum: float, bore: float) -> Iterator[Problem]:
    root_radius = 0.5 * module * pinion_teeth - rack_addendum
    if root_radius <= 0.0:
        fix = "the pinion's root would lie at its axis: the addendum of a rack is usually 1.25 modules"
        allowed = f"less than the pinion's pitch radius ({mm(root_radius + rack_addendum)} mm)"
        yield Problem("gear_pair.rack_addendum_mm", rack_addendum, allowed, fix)
    elif bore >= root_radius:
        allowed = f"less than the pinion's root radius ({mm(root_radius)} mm)"
        yield Problem("gear_pair.pinion_bore_radius_mm", bore, allowed, "give a radius, not a diameter")


for _body in BODIES:

    @_across("gear_pair", f"{_body}_face_width_mm", f"{_body}_end_edge_radius_mm")
    def _end_edges_fit(width: float, radius: float, body: str = _body) -> Iterator[Problem]:
        yield from _edge_fits(f"{body}_end_edge_radius_mm", radius, width / 2.0, "half the face width")

    @_across("gear_pair", f"{_body}_addendum_mm", f"{_body}_tip_edge_radius_mm")
    def _tip_edge_fits(addendum: float, radius: float, body: str = _body) -> Iterator[Problem]:
        yield from _edge_fits(f"{body}_tip_edge_radius_mm", radius, addendum, f"{body}_addendum_mm")


@_across("gear_pair", "gear_inner_radius_mm", "gear_outer_radius_mm", "gear_end_edge_radius_mm")
def _gear_end_edges_fit(inner: float, outer: float, radius: float) -> Iterator[Problem]:
    yield from _edge_fits("gear_end_edge_radius_mm", radius, (outer - inner) / 2, "half the face width")


def _edge_fits(name: str, radius: float, limit: float, limit_name: str) -> Iterator[Problem]:
    """Problem of an edge radius that leaves no flank."""
    if radius >= limit:
        fix = "an edge radius is small, usually 0.2 mm at a module of 5"
        yield Problem(f"gear_pair.{name}", radius, f"less than {limit_name} ({mm(limit)} mm)", fix)


@_across("wear.until", "meshes", "hours", "control_depths_um")
def _one_end_of_the_run(
    meshes: float | None, hours: float | None, depths: tuple[float, ...] | None
) -> Iterator[Problem]:
    allowed = "exactly one of meshes, hours and control_depths_um"
    ends = {"meshes": meshes, "hours": hours, "control_depths_um": None if depths is None else list(depths)}
    given = {name: end for name, end in ends.items() if end is not None}
    if not given:
        yield Problem("wear.until", None, allowed, "needed by [wear]: add the end of the run")
    elif len(given) > 1:
        yield Problem("wear.until", shown(given), allowed, "remove one of them")


@_across("", "wear.until.hours", "operation.pinion_speed_rpm")
def _hours_have_a_speed(hours: float | None, speed: float | None) -> Iterator[Problem]:
    if hours is not None and speed is None:
        fix = "needed by wear.until.hours: add it, or give wear.until.meshes instead"
        yield Problem("operation.pinion_speed_rpm", None, "greater than 0 rev/min", fix)


@_across("wear", "wear.until.control_depths_um", "wear.control_point.radius_mm")
def _control_point_is_given(depths: tuple[float, ...] | None, radius: float | None) -> Iterator[Problem]:
    if depths is not None and radius is None:
        allowed = "a table with radius_mm and height_mm"
        fix = "needed by [wear.until] control_depths_um: add it, or give meshes instead"
        yield Problem("wear.control_point", None, allowed, fix)


@_across("wear.control_point", "body", "wear.worn_bodies")
def _watched_flank_wears(body: str | None, bodies: tuple[str, ...]) -> Iterator[Problem]:
    if body is not None and body not in bodies:
        worn = ", ".join(f'"{name}"' for name in bodies)
        allowed = f"one of wear.worn_bodies: {worn}"
        fix = f'add "{body}" to wear.worn_bodies, or give "{bodies[0]}" and a point on its flank'
        yield Problem("wear.control_point.body", body, allowed, fix)


@_across("wear", "worn_bodies", "coefficient_mm2_per_N")
def _every_worn_body_has_a_coefficient(
    bodies: tuple[str, ...], coefficient: float | BodyCoefficients
) -> Iterator[Problem]:
    if not isinstance(coefficient, BodyCoefficients):
        return
    given = coefficient.given
    missing = [body for body in bodies if body not in given]
    if missing:
        allowed = f"with {' and '.join(missing)}, as needed by wear.worn_bodies"
        fix = f"add {', '.join(f'{body} = 1e-13' for body in missing)}, or give one number for both bodies"
        yield Problem("wear.coefficient_mm2_per_N", given, allowed, fix)


@_across("wear", "worn_bodies", "numerics.wear_mapping")
def _marched_wear_is_of_the_gear(bodies: tuple[str, ...], mapping: str) -> Iterator[Problem]:
    if mapping == "marched" and "pinion" in bodies:
        fix = 'leave numerics.wear_mapping out, or wear the gear alone: wear.worn_bodies = ["gear"]'
        yield Problem("numerics.wear_mapping", mapping, '"interpolated" where "pinion" is in wear.worn_bodies', fix)


@_across(
    "gear_pair",
    "gear_inner_radius_mm",
    "gear_outer_radius_mm",
    "pinion_centre_mm",
    "pinion_face_width_mm",
    "wear.control_point.radius_mm",
)
def _control_point_is_in_the_face(
    inner: float, outer: float, centre: float, width: float, radius: float | None
) -> Iterator[Problem]:
    low, high = max(inner, centre - width / 2), min(outer, centre + width / 2)
    if radius is not None and not low <= radius <= high:
        allowed = f"{mm(low)} to {mm(high)} mm, the part of the gear's face that the pinion covers"
        yield Problem("wear.control_point.radius_mm", radius, allowed, "a gear radius, not a diameter")


@_across(
    "gear_pair",
    "shaper_addendum_mm",
    "gear_addendum_mm",
    "rack_addendum_mm",
    "pinion_addendum_mm",
    "wear.worn_bodies",
    "wear.control_point.body",
    "wear.control_point.height_mm",
)
def _control_point_is_on_the_tooth(
    gear_dedendum: float,
    gear_addendum: float,
    pinion_dedendum: float,
    pinion_addendum: float,
    bodies: tuple[str, ...],
    named: str | None,
    height: float | None,
) -> Iterator[Problem]:
    body = named or default_watched_body(bodies)
    low, high, pitch = -gear_dedendum, gear_addendum, "pitch plane"
    if body == "pinion":
        low, high, pitch = -pinion_dedendum, pinion_addendum, "pitch cylinder"
    if height is not None and not low <= height <= high:
        allowed = f"{mm(low)} to {mm(high)} mm, root to tip of the {body} tooth"
        fix = f"the height above the {pitch}, negative on the dedendum"
        yield Problem("wear.control_point.height_mm", height, allowed, fix)


@_across("numerics", "fidelity", "wear_mapping")
def _marched_wear_has_patches(fidelity: str, mapping: str) -> Iterator[Problem]:
    if mapping == "marched" and fidelity != "patch":
        fix = 'set numerics.fidelity = "patch", or leave numerics.wear_mapping out'
        yield Problem("numerics.wear_mapping", mapping, f'"interpolated" at fidelity "{fidelity}"', fix)
