"""Limits of a cylindrical pair's teeth as numbers: where undercut, pointing and interference begin.

References
----------
ISO 21771:2007 (form and active diameters, tip interference of internal pairs).
"""

from __future__ import annotations

from dataclasses import replace
from math import acos, atan, cos, hypot, pi, sin, tan

import numpy as np

from semiwear.check.limits import crossing
from semiwear.geometry.cylindrical import CylindricalTooth
from semiwear.geometry.involute import involute_function
from semiwear.meshing.cylindrical_pair import CylindricalMesh
from semiwear.scene import CylindricalPair
from semiwear.scene.cylindrical import zero_backlash_distance

_SHIFT_DIGITS = 1e-3  # modules: a centre distance is met by shifts written with a few digits
_MOST_MODULES = 8.0  # above the reference cylinder, where teeth of any usual pressure angle are pointed already


def teeth_of(mesh: CylindricalMesh) -> tuple[tuple[str, CylindricalTooth], ...]:
    """Names and teeth of pinion and gear."""
    return ("pinion", mesh.pinion), ("gear", mesh.gear)


def tight_distance(table: CylindricalPair) -> float:
    """Centre distance without backlash [mm]."""
    return zero_backlash_distance(
        table.normal_module_mm, table.pressure_angle_deg, table.helix_angle_deg, table.pinion_teeth,
        table.gear_teeth, table.pinion_profile_shift, table.gear_profile_shift,
    )  # fmt: skip


def jamming_distance(table: CylindricalPair) -> float:
    """Centre distance beyond which the teeth jam [mm]: without backlash, less what the digits of the shifts leave."""
    tight = tight_distance(table)
    angle = replace(table, centre_distance_mm=tight).working_pressure_angle
    slack = _SHIFT_DIGITS * table.normal_module_mm * cos(angle)
    return tight + slack if table.internal else tight - slack


def least_profile_shift(tooth: CylindricalTooth) -> float:
    """Profile shift coefficient from which the rack does not undercut an external tooth."""
    deepest = tooth.reference_radius * sin(tooth.pressure_angle) ** 2
    return tooth.profile_shift + (tooth.straight_depth - deepest) / tooth.normal_module


def pointed_diameter(tooth: CylindricalTooth) -> float:
    """Tip diameter at which both flanks of a tooth meet [mm]; of an internal tooth at least the base diameter."""
    if tooth.internal:
        if tooth.half_thickness(tooth.base_radius) > 0.0:
            return 2.0 * tooth.base_radius
        return 2.0 * crossing(tooth.half_thickness, tooth.reference_radius, tooth.base_radius)
    beyond = tooth.reference_radius + _MOST_MODULES * tooth.normal_module
    return 2.0 * crossing(tooth.half_thickness, tooth.reference_radius, beyond)


def root_limits(mesh: CylindricalMesh) -> tuple[float, float]:
    """Tip radii of pinion and gear at which they reach the other body's root [mm]."""
    pinion, gear = mesh.pinion, mesh.gear
    distance = mesh.table.centre_distance_mm
    of_gear = distance - gear.side * pinion.root_radius
    return gear.side * (distance - gear.root_radius), of_gear


def deepest_rolls(mesh: CylindricalMesh) -> tuple[float, float]:
    """Roll angles on pinion and gear that the other body's tip reaches on the path of contact [rad]."""
    first, last = mesh.path_limits
    pinion, gear = mesh.pinion, mesh.gear
    pinion_working, gear_working = mesh.working_radii
    on_pinion = pinion.roll_at(pinion_working) - first / pinion.base_radius
    return on_pinion, gear.roll_at(gear_working) + gear.side * last / gear.base_radius


def tip_limits(mesh: CylindricalMesh) -> tuple[float, float]:
    """Tip diameters of pinion and gear at which they reach the end of the other body's involute [mm]."""
    pinion, gear = mesh.pinion, mesh.gear
    pinion_working, gear_working = mesh.working_radii
    on_gear = gear.side * gear.base_radius * (gear.roll_at(gear_working) - max(gear.form_roll_angle, 0.0))
    pinion_roll = pinion.roll_at(pinion_working) + on_gear / pinion.base_radius
    on_pinion = pinion.base_radius * (pinion.roll_at(pinion_working) - max(pinion.form_roll_angle, 0.0))
    gear_roll = gear.roll_at(gear_working) + gear.side * on_pinion / gear.base_radius
    pinion_limit, gear_limit = (
        2.0 * tooth.base_radius * float(hypot(1.0, max(roll, 0.0)))
        for tooth, roll in ((pinion, pinion_roll), (gear, gear_roll))
    )
    return pinion_limit, gear_limit


def edge_limits(mesh: CylindricalMesh) -> tuple[float, float]:
    """Tip edge radii of pinion and gear at which no top land, or no flank, would be left [mm]."""
    middle = np.zeros(1)
    sharp = mesh.borders(middle, sharp=True)
    flanks = sharp.driving_tip - sharp.driving_root, float((sharp.tip - sharp.root)[0])
    pinion, gear = (
        min(tooth.half_thickness(tooth.tip_radius), flank) / tan(0.5 * turn)
        for (_, tooth), flank, turn in zip(
            teeth_of(mesh), flanks, (sharp.driving_tip_turn, float(sharp.tip_turn[0])), strict=True
        )
    )
    return pinion, gear


def tip_passage(mesh: CylindricalMesh) -> float:
    """Angular clearance of the tips of an internal pair at the intersection of the tip cylinders [rad].

    It is an angle of the gear; if negative, the tips interfere (ISO 21771; "fouling").
    """
    pinion, gear = mesh.pinion, mesh.gear
    distance = mesh.table.centre_distance_mm
    r1, r2 = pinion.tip_radius, gear.tip_radius
    cosine_1 = (r2**2 - r1**2 - distance**2) / (2.0 * distance * r1)
    cosine_2 = (distance**2 + r2**2 - r1**2) / (2.0 * distance * r2)
    if not (abs(cosine_1) < 1.0 and abs(cosine_2) < 1.0):
        return pi
    working = involute_function(mesh.table.working_pressure_angle)

    def involute_at(tooth: CylindricalTooth) -> float:
        return tooth.tip_roll_angle - atan(tooth.tip_roll_angle)

    turned = (acos(cosine_1) + involute_at(pinion) - working) * pinion.teeth / gear.teeth
    return turned + working - involute_at(gear) - acos(cosine_2)
