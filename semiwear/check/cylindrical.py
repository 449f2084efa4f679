"""Limits of a cylindrical gear pair that need tooth geometry: undercut, pointing, interference, contact ratio.

References
----------
ISO 21771:2007 (form and active diameters, contact ratios, tip interference of internal pairs); ISO 53 (basic rack).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import isfinite
from typing import cast

import numpy as np

from semiwear.check.cylindrical_limits import (
    deepest_rolls,
    edge_limits,
    jamming_distance,
    least_profile_shift,
    pointed_diameter,
    root_limits,
    teeth_of,
    tight_distance,
    tip_limits,
    tip_passage,
)
from semiwear.check.limits import Limit, crossing, down, find_problems, problem_of, up, watched_point
from semiwear.errors import Problem
from semiwear.meshing.cylindrical_pair import CylindricalMesh
from semiwear.meshing.flank_pair import BODIES, DRIVEN
from semiwear.scene import CylindricalControlPoint, CylindricalPair, Placement, Scene

_MOST_ROLLS = 2.9  # base pitches from the pitch point up to which tooth pairs are considered


def cylindrical_problems(scene: Scene) -> list[Problem]:
    """Problems of a cylindrical pair's teeth; see `semiwear.check.geometric_problems`."""
    table = cast(CylindricalPair, scene.gear_pair)
    distance = list(_teeth_fit_the_centre_distance(scene, table))
    if distance:
        return distance
    mesh = CylindricalMesh(table, Placement())
    return find_problems(scene, mesh, _LIMITS, "spur_fzg_c", (_control_point_is_on_the_flank,))


def _teeth_fit_the_centre_distance(scene: Scene, table: CylindricalPair) -> Iterator[Problem]:
    """The centre distance leaves a line of action between the base circles, and the teeth do not jam."""
    t = table
    tight = tight_distance(t)
    side = -1.0 if t.internal else 1.0
    if not isfinite(tight):
        fix = f"there is no centre distance for such shifts: {'lower' if t.internal else 'raise'} their sum"
        allowed = f"a {'smaller' if t.internal else 'greater'} profile shift"
        farthest = max if t.internal else min  # from what there is a centre distance for
        shift = farthest(("gear_profile_shift", "pinion_profile_shift"), key=lambda name: float(getattr(t, name)))
        yield problem_of(scene, shift, allowed, fix)
        return
    if not isfinite(t.working_pressure_angle):
        allowed = f"{'up to' if t.internal else 'at least'} {(down if t.internal else up)(tight)} mm"
        fix = "there is no line of action between the base circles: leave it out for the distance without backlash"
        yield problem_of(scene, "centre_distance_mm", allowed, fix)
        return
    if side * (t.centre_distance_mm - jamming_distance(t)) < 0.0:
        allowed = f"{'up to' if t.internal else 'at least'} {(down if t.internal else up)(tight)} mm"
        fix = "the teeth jam: leave it out for the distance without backlash, or lower the sum of the profile shifts"
        yield problem_of(scene, "centre_distance_mm", allowed, fix)


def _rack_does_not_undercut(scene: Scene, mesh: CylindricalMesh) -> Iterator[Problem]:
    """The rack's straight flank ends before the point at which the line of action touches the base circle."""
    for body, tooth in teeth_of(mesh):
        if tooth.internal or tooth.form_roll_angle >= 0.0:
            continue
        fix = f"{tooth.teeth} teeth are below the limit of undercut: they need a profile shift, or more teeth"
        yield problem_of(scene, f"{body}_profile_shift", f"at least {up(least_profile_shift(tooth))}", fix)


def _teeth_are_not_pointed(scene: Scene, mesh: CylindricalMesh) -> Iterator[Problem]:
    """The two flanks of a tooth do not meet below its tip."""
    for body, tooth in teeth_of(mesh):
        field = f"{body}_tip_diameter_mm"
        if tooth.internal and tooth.tip_radius < tooth.base_radius:
            fix = "an involute ends at the base circle: give more, or a positive profile shift"
            yield problem_of(scene, field, f"at least {up(2.0 * tooth.base_radius)} mm (base circle)", fix)
        elif tooth.side * (tooth.tip_radius - tooth.root_radius) <= 0.0:
            fix = "the tip lies below the root: leave it out for its default, or give a profile shift nearer to zero"
            yield problem_of(scene, field, f"{'below' if tooth.internal else 'above'} the root diameter", fix)
        elif tooth.half_thickness(tooth.tip_radius) <= 0.0:
            limit = pointed_diameter(tooth)
            fix = "the teeth are pointed: give " + ("more" if tooth.internal else "less, or less profile shift")
            allowed = f"above {up(limit)} mm" if tooth.internal else f"below {down(limit)} mm"
            yield problem_of(scene, field, allowed, fix)


def _internal_fillet_fits(scene: Scene, mesh: CylindricalMesh) -> Iterator[Problem]:
    """The fillet arc of an internal gear fits into the tooth space."""
    gear = mesh.gear
    if not gear.internal or gear.root_land_half_angle >= 0.0:
        return

    def land(radius: float) -> float:
        return replace(gear, rack_tip_radius=radius).root_land_half_angle

    if land(0.0) < 0.0:
        fix = "the flanks meet before the root: give less, usually 1.25 modules, or less profile shift"
        yield problem_of(scene, "gear_rack_addendum_mm", "a root that leaves a land in the tooth space", fix)
        return
    greatest = crossing(land, 0.0, gear.rack_tip_radius)
    fix = "the tooth space is fully round: give less, or lower gear_rack_addendum_mm"
    yield problem_of(scene, "gear_rack_tip_radius_mm", f"0 to {down(greatest)} mm", fix)


def _roots_are_clear(scene: Scene, mesh: CylindricalMesh) -> Iterator[Problem]:
    """A tip does not reach the other body's root."""
    pinion, gear = mesh.pinion, mesh.gear
    pinion_limit, gear_limit = root_limits(mesh)
    if pinion.tip_radius >= pinion_limit:
        fix = "its tips need bottom clearance in the gear's roots: give less, or raise gear_rack_addendum_mm"
        yield problem_of(scene, "pinion_tip_diameter_mm", f"below {down(2.0 * pinion_limit)} mm", fix)
    if gear.side * (gear.tip_radius - gear_limit) >= 0.0:
        fix = "its tips need bottom clearance in the pinion's roots, or raise pinion_rack_addendum_mm"
        less = "above" if gear.internal else "below"
        yield problem_of(scene, "gear_tip_diameter_mm", f"{less} {2.0 * gear_limit:.6g} mm", fix)


def _tips_clear_the_fillets(scene: Scene, mesh: CylindricalMesh) -> Iterator[Problem]:
    """On the path of contact each tip touches the mate's involute: not its fillet, nor inside its base circle."""
    pinion, gear = mesh.pinion, mesh.gear
    on_pinion, on_gear = deepest_rolls(mesh)
    pinion_limit, gear_limit = tip_limits(mesh)
    if on_pinion < pinion.form_roll_angle:
        fix = "the gear's tip would touch the pinion's fillet: lower pinion_rack_tip_radius_mm, or shift the profiles"
        allowed = f"at least {up(gear_limit)} mm" if gear.internal else f"up to {down(gear_limit)} mm"
        yield problem_of(scene, "gear_tip_diameter_mm", allowed, fix)
    if gear.side * (on_gear - gear.form_roll_angle) < 0.0:
        fix = "the pinion's tip would touch the gear's fillet: lower gear_rack_tip_radius_mm, or shift the profiles"
        yield problem_of(scene, "pinion_tip_diameter_mm", f"up to {down(pinion_limit)} mm", fix)


def _teeth_hand_over(scene: Scene, mesh: CylindricalMesh) -> Iterator[Problem]:
    """A tooth pair is still in mesh when the next one enters, and contact stays within `_MOST_ROLLS`."""
    ratio = mesh.transverse_contact_ratio + mesh.overlap_ratio
    if ratio < 1.0:
        found = f"it is {down(ratio)}" if ratio > 0.0 else "these tips do not reach each other"
        allowed = f"tip diameters with a contact ratio of 1 at least; {found}"
        fix = (
            "the teeth part before the next pair enters: lower centre_distance_mm, or raise the tips, the helix "
            "angle or the number of teeth"
        )
        yield problem_of(scene, "pinion_tip_diameter_mm", allowed, fix)
    first, last = (length / mesh.base_pitch for length in mesh.path_limits)
    half = 0.5 * mesh.overlap_ratio + abs(mesh.table.face_offset_mm) / mesh.base_pitch
    reached = max(first, -last) + half
    if reached > _MOST_ROLLS:
        allowed = f"contact within {_MOST_ROLLS:g} base pitches of the pitch point; it reaches {up(reached)}"
        if half > 0.5 * reached:
            fix = f"the contact ratio is {up(ratio)}, most of it overlap: lower the helix angle or the face width"
            yield problem_of(scene, "helix_angle_deg", allowed, fix)
        else:
            body = "pinion" if abs(mesh.table.pinion_profile_shift) >= abs(mesh.table.gear_profile_shift) else "gear"
            fix = "the path of contact lies to one side of the pitch point: give shifts nearer to zero"
            yield problem_of(scene, f"{body}_profile_shift", allowed, fix)


def _tips_of_an_internal_pair_pass(scene: Scene, mesh: CylindricalMesh) -> Iterator[Problem]:
    """The pinion's tips leave the gear's tooth spaces without touching the gear's tips off the path of contact.

    See `tip_passage`.
    """
    pinion, gear = mesh.pinion, mesh.gear
    if not gear.internal:
        return
    if tip_passage(mesh) >= 0.0:
        return
    difference = gear.teeth - pinion.teeth
    fix = (
        f"the tips foul beside the path of contact: {difference} teeth more than the pinion are too few, or lower it"
    )

    def passing(diameter: float) -> float:
        table = replace(mesh.table, pinion_tip_diameter_mm=diameter)
        return tip_passage(CylindricalMesh(table, Placement()))

    low = 2.0 * pinion.reference_radius
    allowed = "a gear with more teeth"
    if passing(low) >= 0.0:
        allowed = f"below {down(crossing(passing, low, 2.0 * pinion.tip_radius))} mm"
    yield problem_of(scene, "pinion_tip_diameter_mm", allowed, fix)


def _rims_have_thickness(scene: Scene, mesh: CylindricalMesh) -> Iterator[Problem]:
    """There is material under the roots."""
    if mesh.pinion.rim_thickness <= 0.0:
        allowed = f"less than the pinion's root radius ({down(mesh.pinion.root_radius)} mm)"
        yield problem_of(scene, "pinion_bore_radius_mm", allowed, "give a radius, not a diameter")
    if not mesh.gear.internal and mesh.gear.rim_thickness >= mesh.gear.root_radius:
        allowed = f"less than the gear's root radius ({down(mesh.gear.root_radius)} mm)"
        yield problem_of(scene, "gear_rim_thickness_mm", allowed, "the gear is a ring on a bore: give less")


def _edge_roundings_fit(scene: Scene, mesh: CylindricalMesh) -> Iterator[Problem]:
    """The roundings of a tooth's two tip edges leave a top land and a flank."""
    for body, limit in zip(BODIES, edge_limits(mesh), strict=True):
        # a tooth without a top land is pointed, for which there is another limit
        if 0.0 < limit < getattr(mesh.table, f"{body}_tip_edge_radius_mm"):
            fix = "the roundings of both flanks would meet on the top land: give less, or a lower tip"
            yield problem_of(scene, f"{body}_tip_edge_radius_mm", f"0 to {down(limit)} mm", fix)


def _control_point_is_on_the_flank(scene: Scene, mesh: CylindricalMesh) -> Iterator[Problem]:
    """The control point lies on the active flank, between fillet and tip edge."""
    watched = watched_point(scene, CylindricalControlPoint)
    if watched is None:
        return
    point, index = watched
    tooth, working = (mesh.pinion, mesh.gear)[index], mesh.working_radii[index]
    # on the root side the path of contact ends at the tip of the other body
    along = mesh.path_limits[1] if index == DRIVEN else -mesh.path_limits[0]
    roll = tooth.roll_at(working) + tooth.side * along / tooth.base_radius
    reached = tooth.base_radius * float(np.hypot(1.0, max(roll, 0.0)))
    low, high = tooth.side * (reached - working), tooth.side * (tooth.tip_radius - working)
    if not low <= point.height_mm <= high:
        allowed = f"{up(low)} to {down(high)} mm, the active flank of the {BODIES[index]}"
        fix = f"the height above the working pitch cylinder, where the {BODIES[1 - index]} meets the flank"
        yield Problem("wear.control_point.height_mm", point.height_mm, allowed, fix)


# every limit, with the field of the gear pair named in the message if the limit cannot be computed
_LIMITS: dict[Limit[CylindricalMesh], str] = {
    _rack_does_not_undercut: "pinion_profile_shift",
    _teeth_are_not_pointed: "pinion_tip_diameter_mm",
    _internal_fillet_fits: "gear_rack_tip_radius_mm",
    _roots_are_clear: "pinion_tip_diameter_mm",
    _tips_clear_the_fillets: "gear_tip_diameter_mm",
    _teeth_hand_over: "pinion_tip_diameter_mm",
    _tips_of_an_internal_pair_pass: "pinion_tip_diameter_mm",
    _rims_have_thickness: "pinion_bore_radius_mm",
    _edge_roundings_fit: "pinion_tip_edge_radius_mm",
    _control_point_is_on_the_flank: "gear_tip_diameter_mm",
}
